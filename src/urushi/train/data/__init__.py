"""Parameter distributions, direction sets and the stores of simulated BRDF values."""
