"""Textures of latent codes: baked texel by texel, packed into bytes, averaged into mip pyramids."""
