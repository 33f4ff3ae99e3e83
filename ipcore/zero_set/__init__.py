"""The zero set f = 0 in a box: found on a grid, moved onto f = 0, measured against the data."""
