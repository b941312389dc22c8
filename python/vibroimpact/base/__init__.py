"""General utilities: checks of arguments, errors, files, progress, interruption, optional libraries."""
