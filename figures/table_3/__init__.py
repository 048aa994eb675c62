"""Table 3 of Fan et al. (2022): three scenes by networks and by random walk at equal time."""
