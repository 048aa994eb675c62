"""Objects nested in a scene object, which of its textures vary, and what is known of a BSDF.

A coat uses what is known of the BSDF below it besides its values.

Of Mitsuba's own, `roughconductor` with the GGX distribution is a lobe and nothing else,
`roughplastic` and an isotropic `pplastic` have one, and `diffuse` has none; so has a `blendbsdf` of
`diffuse` and one of them. All are read from their parameters. Others are known by their values
alone.
"""

from collections.abc import Mapping
from functools import cache, partial

import drjit as dr
import mitsuba as mi

from urushi.checks import MIN_ALPHA
from urushi.errors import ParameterError
from urushi.mitsuba import spectrum
from urushi.mitsuba.surface import KnownSurface, surface_of
from urushi.nets.lobe import NO_LOBE

#: Classes of Mitsuba's textures that are not functions of uv, and their description in errors.
ELSEWHERE = {
    "MeshAttribute": "a mesh attribute, which is given on a mesh",
    "VolumeAdapter": "a volume, which is given in space",
}

#: Classes of Mitsuba's BSDFs that change normals, and their plugins.
NORMALS = {"NormalMap": "normalmap", "BumpMap": "bumpmap"}

#: Texels of a bitmap that are compared before all others.
FIRST = 64

#: The line of a BSDF's description that names its distribution, which it does not list
#: among its parameters.
GGX = "distribution = ggx"

#: Mitsuba's rough plastics.
PLASTICS = ("RoughPlastic", "PolarizedPlastic")


def varying_textures(root: "mi.Object") -> list["mi.Texture"]:
    """The textures that depend on the position, anywhere in a scene object."""
    return [node for node in _within(root) if isinstance(node, mi.Texture) and varies(node)]


def varies(texture: "mi.Texture") -> bool:
    """Whether a texture depends on the position.

    A bitmap of one value does not, unless it carries gradients, which an optimiser may make differ.
    """
    if texture.class_name() in ELSEWHERE:  # mesh attributes report that they do not vary
        return True
    if not (texture.is_spatially_varying() and texture.class_name().startswith("BitmapTexture")):
        return texture.is_spatially_varying()
    data = mi.traverse(texture)["data"]
    if data.array.index_ad:  # `dr.grad_enabled` is false where gradients are suspended
        return True
    texels = data.numpy().reshape(-1, data.shape[-1])
    return any((part != texels[0]).any() for part in (texels[:FIRST], texels))


def check_nodes(node: "mi.Object", where: str) -> None:
    """Refuse, by a ParameterError, normal maps, bump maps and textures that cannot be read.

    An update may give a bitmap a number of channels that Mitsuba does not read correctly.
    """
    for part in _within(node):
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


def not_over_uv(root: "mi.Object") -> str | None:
    """Description of a texture in a scene object that is not a function of uv, or None."""
    names = [texture.class_name() for texture in varying_textures(root)]
    return next((ELSEWHERE[name] for name in names if name in ELSEWHERE), None)


def _within(root: "mi.Object") -> list["mi.Object"]:
    """A scene object and all objects nested in it, each once."""
    nodes, pending = {}, [root]
    while pending:
        node = pending.pop()
        if id(node) not in nodes:
            nodes[id(node)] = node
            pending += nested_objects(node).values()
    return list(nodes.values())


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


def known_surface(bsdf: "mi.BSDF") -> KnownSurface:
    """What is known of a BSDF, or of the front side of Mitsuba's `twosided`."""
    surface = surface_of(bsdf)
    if surface is not None:
        return surface.known()
    while bsdf.class_name() == "TwoSidedBRDF":
        bsdf = nested_objects(bsdf)["brdf_0"]
    if bsdf.class_name() == "SmoothDiffuse":
        channels = partial(_channels, nested_objects(bsdf), "reflectance")
        return KnownSurface(
            lobes=lambda si: [[*map(mi.Float, NO_LOBE)] for _ in channels(si)], reflectance=channels
        )
    plastic = bsdf.class_name() in PLASTICS and "alpha_u" not in nested_objects(bsdf)
    if plastic and GGX in str(bsdf):
        return KnownSurface(lobes=partial(_plastic_lobes, bsdf), table_source=lambda: bsdf)
    if bsdf.class_name() == "BlendBSDF":
        return _known_blend(bsdf)
    if bsdf.class_name() == "RoughConductor" and GGX in str(bsdf):
        return KnownSurface(lobes=partial(_conductor_lobes, nested_objects(bsdf)), lobe_only=True)
    return KnownSurface()


def _known_blend(blend: "mi.BSDF") -> KnownSurface:
    """The lobe of a `blendbsdf` of a Lambertian BSDF and one of a known lobe; else nothing."""
    parts = nested_objects(blend)
    known = [known_surface(parts[name]) for name in ("bsdf_0", "bsdf_1")]
    glossy = [index for index, part in enumerate(known) if part.reflectance is None]
    if len(glossy) != 1 or not (known[glossy[0]].lobe_only or known[glossy[0]].table_source()):
        return KnownSurface()
    lobes_of_part = known[glossy[0]].lobes

    def lobes(si) -> list[list] | None:
        weight = dr.clip(parts["weight"].eval_1(si), 0, 1)
        share = weight if glossy[0] else 1 - weight
        found = lobes_of_part(si)
        return found and [[x[0], *(share * y for y in x[1:4]), *x[4:]] for x in found]

    return KnownSurface(lobes=lobes, table_source=lambda: blend)


def _conductor_lobes(textures: Mapping[str, "mi.Texture"], si) -> list[list]:
    """The lobes of a conductor: six or seven Dr.Jit floats for each channel."""
    names = ("alpha_u", "alpha_v") if "alpha_u" in textures else ("alpha",)
    given = (textures[name].eval_1(si) for name in names)
    # The derivative passes the bound, so that an optimiser can leave it.
    alpha, *across = (dr.replace_grad(dr.maximum(x, MIN_ALPHA), x) for x in given)
    columns = [_channels(textures, x, si) for x in ("specular_reflectance", "eta", "k")]
    found = []
    for reflectance, eta, k in zip(*columns, strict=True):
        # Mitsuba's metal "none" has the index 0 and reflects all light.
        exact = eta > 0
        schlick = dr.select(exact, 0, reflectance)
        index = dr.select(exact, eta, NO_LOBE[4]), dr.select(exact, k, 0)
        factors = schlick, schlick, dr.select(exact, reflectance, 0)
        found.append([alpha, *factors, *index, *across])
    return found


def _plastic_lobes(plastic: "mi.BSDF", si) -> list[list]:
    """The lobes of a plastic: six Dr.Jit floats for each channel."""
    given, textures, zero = mi.traverse(plastic), nested_objects(plastic), mi.Float(0)
    alpha, eta = (
        textures[name].eval_1(si) if name in textures else mi.Float(given[name])
        for name in ("alpha", "eta")
    )
    alpha = dr.replace_grad(dr.maximum(alpha, MIN_ALPHA), alpha)
    tints = _channels(textures, "specular_reflectance", si)
    return [[alpha, zero, zero, tint, eta, zero] for tint in tints]


def _channels(textures: Mapping[str, "mi.Texture"], name: str, si) -> list:
    """The channels of a texture; ones if it is missing."""
    if name in textures:
        return spectrum.to_channels(textures[name].eval(si))
    return [mi.Float(1)] * len(spectrum.to_channels(mi.Spectrum(0)))
