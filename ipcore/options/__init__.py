"""The options of a fit: their names, their ranges, and which of them exclude each other."""
