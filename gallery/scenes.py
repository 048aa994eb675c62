"""The scenes of the gallery by name."""

from gallery.brushed import brushed
from gallery.caddy import caddy
from gallery.car import car
from gallery.export import Scene
from gallery.glass import glass
from gallery.globe import globe
from gallery.leaf import leaf
from gallery.library import library_spheres
from gallery.shoe import shoe
from gallery.still_life import still_life
from gallery.teapot import teapot

#: The demo's scene, then in the order of the README's pictures.
SCENES: dict[str, Scene] = {
    "caddy": caddy,
    "still-life": still_life,
    "globe": globe,
    "teapot": teapot,
    "shoe": shoe,
    "brushed": brushed,
    "car": car,
    "leaf": leaf,
    "glass": glass,
    "library": library_spheres,
}
