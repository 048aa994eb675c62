"""Spheres under coats of varying roughness and media; after Figure 6 of Fan et al. 2022."""
