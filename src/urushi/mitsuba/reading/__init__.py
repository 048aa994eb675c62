"""Reads scenes when they are loaded: coats, textures, values of BSDFs; and bakes their codes."""
