"""The properties that Mitsuba gives a plugin: their names, files and weights."""

from collections.abc import Collection

import mitsuba as mi

from urushi.errors import ParameterError, choice
from urushi.nets import weights
from urushi.nets.weights import Model

#: Properties by which a plugin makes another: how its errors begin, and whether it is a part of a
#: slab.
INTERNAL = ("origin", "inner")


def describe(props: "mi.Properties") -> str:
    """The plugin's name, and its id if the user gave one; begins errors.

    Plugins that make others give them their own text as the property "origin".
    """
    if "origin" in props:
        return props["origin"]
    name = props.id()
    return props.plugin_name() + (f" '{name}'" if name and not name.startswith("__") else "")


def check_names(props: "mi.Properties", names: Collection[str], where: str) -> None:
    """Refuse a property that is none of `names` and no nested BSDF. Call this before reading any.

    Listing the objects resets Mitsuba's record of which properties were read.
    """
    objects = dict(props.objects(mark_queried=False))
    for name in props.keys():  # noqa: SIM118  (no mapping)
        if name not in (*names, *INTERNAL) and not isinstance(objects.get(name), mi.BSDF):
            raise ParameterError(f"{where}: there is no parameter '{name}'; {choice(name, names)}")


def read_weights(props: "mi.Properties") -> Model | None:
    """The weights that the property `weights` names; None without it: shipped ones that fit."""
    name = props.get("weights", "")
    if not name:
        return None
    shipped = weights.DEFAULT, weights.ANISOTROPIC
    return weights.find(name if name in shipped else path_of(props, "weights"))


def path_of(props: "mi.Properties", name: str) -> str:
    """The file that a property names, found as Mitsuba does: relative to the scene file, then to
    the working folder."""
    path = props[name]
    if not isinstance(path, str):
        raise ParameterError(f"{describe(props)}: {name} is {path}; give the path of a file")
    return str(mi.file_resolver().resolve(path))


def switch_of(props: "mi.Properties", name: str, *, default: bool = False) -> bool:
    """A property that is true or false."""
    value = props.get(name, default)
    if not isinstance(value, bool):
        raise ParameterError(f"{describe(props)}: {name} is {value!r}; give true or false")
    return value
