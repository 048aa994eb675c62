"""What scenes hold: a coat's parameters, their textures, and Mitsuba's BSDFs at given pairs."""
