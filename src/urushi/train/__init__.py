"""Training of the networks with JAX and optax (the optional extra `train`)."""
