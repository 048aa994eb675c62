"""The gallery: scenes made by code. The package contains the files of one, `caddy`.

`python -m gallery NAME FOLDER` writes one; `urushi render FOLDER/scene.xml` renders it.
"""
