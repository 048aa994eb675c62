"""Directions in NumPy: half vectors, sets of pairs, quadrature, and the errors E and P."""
