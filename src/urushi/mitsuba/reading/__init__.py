"""Reads scenes: parameters of coats, their textures, and values of BSDFs at given pairs."""
