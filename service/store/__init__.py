"""Where fits and their inputs are kept."""
