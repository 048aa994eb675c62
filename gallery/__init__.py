"""The gallery: scenes made by code, beside the two that the package ships.

`python -m gallery NAME FOLDER` writes one; `urushi render FOLDER/scene.xml` renders it.
"""
