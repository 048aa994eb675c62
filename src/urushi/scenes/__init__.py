"""The shipped scenes, made by code: shapes, textures, lights, and their export to Mitsuba's XML."""
