"""Independent solutions of the same transport, which the tests compare the random walk with."""
