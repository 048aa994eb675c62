"""Mip levels of latent textures against averages of BRDFs and supersampled pictures."""
