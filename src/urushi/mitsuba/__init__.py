"""Mitsuba 3 plugins: `layered` (a random walk), `neural_layered` and others.

`surface` holds what all plugins share, and the adapter by which Mitsuba sees them. `register` makes
them known to Mitsuba and `plugins` defines them. `reading` evaluates the textures and BSDFs that a
scene gives them. `latents` bakes latent codes from these, constant, textured or with gradients, and
evaluates and samples them inside Dr.Jit's kernels.
"""
