"""Urushi: layered materials in a neural latent space, for Mitsuba 3."""

__version__ = "0.1.0"
