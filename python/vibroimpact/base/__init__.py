"""What any program needs: checks of arguments, errors, files, progress, interruption, optional libraries."""
