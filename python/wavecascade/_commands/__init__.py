"""The commands of the program as functions on arrays."""
