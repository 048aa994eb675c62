"""Table 1 of Fan et al. (2022): neural representations of single BRDFs, measured."""
