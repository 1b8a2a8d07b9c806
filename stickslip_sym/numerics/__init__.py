"""What searches for numbers stand on: what is not known, Chebyshev polynomials, intervals that are divided."""
