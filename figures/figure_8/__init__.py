"""Stacks of two to six interfaces; after Figure 8 of Fan et al. 2022."""
