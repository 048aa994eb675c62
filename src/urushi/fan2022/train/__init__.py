"""Training of the paper's networks as the paper describes it, at any scale."""
