"""Mitsuba 3 plugins: `layered` (a random walk), `neural_layered`, `neural_brdf`, `measured_brdf`.

`register` makes them known to Mitsuba. In `plugins` they are defined; `reading` looks at what a
scene gives them; `codes` makes latent codes of it, constant, textured or with gradients; `networks`
evaluates and samples codes inside Dr.Jit's kernels; `scenes` holds the shipped scenes.
"""
