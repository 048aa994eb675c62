"""Errors of networks on held-out stacks, and violations of laws; see docs/evaluation.md."""
