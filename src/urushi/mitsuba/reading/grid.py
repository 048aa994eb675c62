"""Objects nested in a scene object, and which of its textures vary."""

from functools import cache

import mitsuba as mi

from urushi.errors import ParameterError
from urushi.mitsuba.snapshot import is_attached

#: Classes of Mitsuba's textures that are not functions of uv, and their description in errors.
ELSEWHERE = {
    "MeshAttribute": "a mesh attribute, which is given on a mesh",
    "VolumeAdapter": "a volume, which is given in space",
}

#: Classes of Mitsuba's BSDFs that change normals, and their plugins.
NORMALS = {"NormalMap": "normalmap", "BumpMap": "bumpmap"}

#: Texels of a bitmap that are compared before all others.
FIRST = 64


def varying_textures(*roots: "mi.Object") -> list["mi.Texture"]:
    """The textures that depend on the position, anywhere in scene objects."""
    nodes = [node for root in roots for node in within(root)]
    return [node for node in nodes if isinstance(node, mi.Texture) and varies(node)]


def varies(texture: "mi.Texture") -> bool:
    """Whether a texture depends on the position.

    A bitmap of one value does not, unless it carries gradients, which an optimiser may make differ.
    """
    if texture.class_name() in ELSEWHERE:  # mesh attributes report that they do not vary
        return True
    if not (texture.is_spatially_varying() and texture.class_name().startswith("BitmapTexture")):
        return texture.is_spatially_varying()
    data = mi.traverse(texture)["data"]
    if is_attached(data):
        return True
    texels = data.numpy().reshape(-1, data.shape[-1])
    return any((part != texels[0]).any() for part in (texels[:FIRST], texels))


def check_nodes(node: "mi.Object", where: str) -> None:
    """Refuse, by a ParameterError, normal maps, bump maps and textures that cannot be read.

    An update may give a bitmap a number of channels that Mitsuba does not read correctly.
    """
    for part in within(node):
        if part.class_name() in NORMALS:
            raise ParameterError(
                f"{where}: the nested BSDF contains a '{NORMALS[part.class_name()]}', and codes "
                "have no normals; put it around the coat, or use the plugin 'layered'"
            )
        if part.class_name().startswith("BitmapTexture"):
            channels = mi.traverse(part)["data"].shape[-1]
            if channels not in (1, 3):
                raise ParameterError(
                    f"{where}: a bitmap was changed to {channels} channels; load the scene again, "
                    "and give it one or three"
                )


def not_over_uv(*roots: "mi.Object") -> str | None:
    """Description of a texture in scene objects that is not a function of uv, or None."""
    names = [texture.class_name() for texture in varying_textures(*roots)]
    return next((ELSEWHERE[name] for name in names if name in ELSEWHERE), None)


def within(root: "mi.Object") -> list["mi.Object"]:
    """A scene object and all objects nested in it, each once."""
    return list(mi.traverse(root).hierarchy)


def nested_objects(node: "mi.Object") -> dict[str, "mi.Object"]:
    """The objects nested in a scene object, by the names under which it lists them."""
    collector = _collector(mi.variant())()
    node.traverse(collector)
    return collector.objects


def parts(bsdf: "mi.BSDF") -> dict[str, "mi.Object"]:
    """The objects nested in a BSDF by their names; of those nested in it, "name.name"."""
    found = {}
    for name, part in nested_objects(bsdf).items():
        found[name] = part
        if isinstance(part, mi.BSDF):
            found |= {f"{name}.{inner}": x for inner, x in parts(part).items()}
    return found


@cache
def _collector(variant: str) -> type:
    """The class of a callback that collects the objects nested in a node, in a variant.

    Defined once: a new class for each node would keep the objects until Python collects cycles.
    """

    class Collector(mi.TraversalCallback):
        def __init__(self):
            super().__init__()
            self.objects = {}

        def put(self, name, value, flags, cpptype=None):
            if isinstance(value, mi.Object):
                self.objects[name] = value

        def put_value(self, name, value, flags, cpptype=None):
            pass

        def put_object(self, name, value, flags):
            if value is not None:
                self.objects[name] = value

    return Collector
