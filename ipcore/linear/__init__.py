"""Linear least-squares fits: the paper's algorithm, and faster ways to the same solution."""
