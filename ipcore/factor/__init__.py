"""Incremental factorisations M = QR: columns are appended, R and b̃ = Qᵀb grow, nothing earlier changes."""
