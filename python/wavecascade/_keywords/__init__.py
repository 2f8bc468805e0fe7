"""Keywords of the functions, and the words of a command line that they are."""
