"""The latent codes of a plugin, looked up in kernels."""
