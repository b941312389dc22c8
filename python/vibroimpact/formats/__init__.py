"""Results as files and as objects of other libraries: code that handles tables, independent of any study."""
