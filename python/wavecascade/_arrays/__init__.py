"""Arrays of the caller to fields, and results to arrays of the caller."""
