"""Point sets in: bytes and files, read, checked, and turned into one npy of doubles."""
