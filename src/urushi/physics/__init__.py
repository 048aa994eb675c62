"""Pure Dr.Jit functions of surface and medium scattering, generic over the backend's types.

Scalars are Dr.Jit floats, directions are Dr.Jit 3-vectors, colours either; nothing here knows of
stacks, networks or Mitsuba. Directions point away from the scattering event unless said otherwise.
"""
