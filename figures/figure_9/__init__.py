"""Measured materials under coats; after Figure 9 of Fan et al. 2022."""
