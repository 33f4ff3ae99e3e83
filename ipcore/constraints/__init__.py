"""Constraint families: each turns oriented points into the rows of a linear system M a = b. One file each."""
