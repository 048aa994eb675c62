"""Importance sampling by the networks' proposal, by that of Fan et al. 2022, and by cosines."""
