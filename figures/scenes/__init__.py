"""Gallery scenes by networks and by the walk; after Figures 1, 10 and 11 of Fan et al. 2022."""
