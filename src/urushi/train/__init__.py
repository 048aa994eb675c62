"""Basis, proposals and layering network, with JAX and optax (the optional extra `train`)."""
