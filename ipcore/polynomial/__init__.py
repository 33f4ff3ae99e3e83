"""What a polynomial is: its terms in graded order, its evaluation, its frame, bounds of its values."""
