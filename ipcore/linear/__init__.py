"""Linear least-squares fits: the paper's algorithm and its family."""
