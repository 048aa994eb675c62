"""Pure Dr.Jit functions of surface and medium scattering, generic over the backend's types.

Scalars are Dr.Jit floats, directions are Dr.Jit 3-vectors, and values are floats or colours.
Nothing here depends on stacks, networks or Mitsuba. Directions point away from the surface unless
stated otherwise.
"""
