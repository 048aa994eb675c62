"""The networks: features, encoder, layerer, decoder and sampler, for arrays of NumPy and JAX.

Every function is pure and takes its array namespace from its inputs (`x.__array_namespace__()`).
Parameters are a flat dictionary of arrays such as ``{"decoder.0.weight": (in, out)}``.
"""
