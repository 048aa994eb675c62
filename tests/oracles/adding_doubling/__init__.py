"""Deterministic adding-doubling solver of layered BRDFs, independent of the random walk.

Azimuthal Fourier modes times Gauss quadrature in the polar cosine (van de Hulst, Multiple Light
Scattering, 1980; Jakob, d'Eon, Jakob and Marschner, A comprehensive framework for rendering layered
materials, 2014; Zeltner and Jakob, The layer laboratory, 2018). For rough interfaces only.
"""

from tests.oracles.adding_doubling.solver import solve

__all__ = ["solve"]
