"""Polynomials: their terms in graded order, their evaluation, their frames, and bounds of their values."""
