"""Published models of layered materials, beside which the networks are measured."""
