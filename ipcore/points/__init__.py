"""What is fitted: points checked, read in pieces, sampled, given normals, oriented."""
