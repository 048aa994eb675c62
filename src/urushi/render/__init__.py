"""Mitsuba 3 plugins: `layered` (the random walk), `neural_layered` and `neural_brdf` (networks).

`register.register` makes them known to Mitsuba; the networks run as Dr.Jit code with their weights
as constants, the twins of what `urushi.nets` computes with NumPy and JAX.
"""
