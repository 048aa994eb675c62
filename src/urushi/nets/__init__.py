"""Codes: the linear basis, lobes, proposals and the layering network, for NumPy and JAX.

Every function is pure and takes its array namespace from its inputs (`x.__array_namespace__()`).
Parameters are a flat dictionary of arrays such as ``{"layerer.0.weight": (in, out)}``.
"""
