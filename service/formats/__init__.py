"""File formats: point sets are read; zero sets and pictures of fits are written."""
