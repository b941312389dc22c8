"""What writes the generated pages: `pages()` of each module gives their names and texts."""
