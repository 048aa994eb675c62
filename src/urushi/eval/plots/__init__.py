"""Plots of an evaluation; they need matplotlib, the extra `eval`."""
