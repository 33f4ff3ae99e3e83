"""Who runs an accepted fit."""
