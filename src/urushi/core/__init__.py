"""Directions and surface scattering: what every floor above shares.

In NumPy: rotations, half vectors, sets of pairs, quadrature, error metrics. On Dr.Jit arrays,
generic over the backend: microfacets, Fresnel, frames. Directions point away from the surface
unless stated otherwise. Nothing here depends on stacks, networks or Mitsuba.
"""
