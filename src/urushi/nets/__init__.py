"""Features, decoder, encoder, layerer and sampler: one definition that runs on NumPy and JAX.

Every function takes its array namespace from its inputs (`x.__array_namespace__()`), holds no
state, and knows no physics: parameters are a flat dict such as ``{"decoder.0.weight": (in, out)}``.
"""
