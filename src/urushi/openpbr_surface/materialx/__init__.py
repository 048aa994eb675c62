"""MaterialX documents: reading them as parameters of OpenPBR, and writing them.

Reading needs no Mitsuba. The package `materialx` reads documents, after their size and form are
checked, and has the library of nodes; `openimageio` reads images and converts colours.
"""
