"""Belcour 2018, the walk and the networks on coated spheres; after Figure 7 of Fan et al. 2022."""
