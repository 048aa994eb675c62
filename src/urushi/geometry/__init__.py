"""Directions in NumPy: frames, half vectors, sets of pairs, quadrature, and the errors E and P."""
