"""The scenes of the gallery by name."""

from gallery.bells import bells
from gallery.brushed import brushed
from gallery.car import car
from gallery.glass import glass
from gallery.globe import globe
from gallery.lantern import lantern
from gallery.leaf import leaf
from gallery.library import library_spheres
from gallery.shoe import shoe
from gallery.still_life import still_life
from gallery.teapot import teapot
from gallery.violin import violin
from urushi.scenes.shipped import Scene

#: In the order of the README's pictures.
SCENES: dict[str, Scene] = {
    "still-life": still_life,
    "globe": globe,
    "teapot": teapot,
    "shoe": shoe,
    "brushed": brushed,
    "bells": bells,
    "violin": violin,
    "car": car,
    "lantern": lantern,
    "leaf": leaf,
    "glass": glass,
    "library": library_spheres,
}
