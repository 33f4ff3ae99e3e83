"""The geometric fit under sign constraints."""
