"""What a fit can be told."""
