"""Point sets in; meshes, outlines and pictures out."""
