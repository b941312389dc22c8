"""Generators of pages: `pages()` of each module gives their names and texts."""
