"""Blends of materials in the latent space against blends of BRDFs and of parameters."""
