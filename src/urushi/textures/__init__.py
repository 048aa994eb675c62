"""Textures of latent codes: baked texel by texel, packed into bytes."""
