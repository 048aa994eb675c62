"""The latent codes of a plugin: baked when a scene is loaded, held, and looked up in kernels."""
