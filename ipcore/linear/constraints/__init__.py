"""Constraint families: each turns oriented points into rows of M a = b. One file each."""
