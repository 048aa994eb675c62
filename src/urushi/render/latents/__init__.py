"""The latent codes of a plugin: how they are made when a scene is loaded, held, and looked up."""
