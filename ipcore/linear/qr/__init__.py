"""Factorisations M = QR of a matrix that grows to the right."""
