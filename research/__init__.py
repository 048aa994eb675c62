"""The laboratory: models by other authors, beside which the networks are measured."""
