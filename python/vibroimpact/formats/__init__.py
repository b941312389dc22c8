"""Results as files and as objects of other libraries: code that knows tables, and no study."""
