"""The parameters of a coat and its bottom that vary over a surface, as axes.

Their values come from Mitsuba's own textures at the shading point, and so does every filter, wrap,
transform, mesh attribute and volume. Between the values, a bottom is known by a plugin of the same
properties whose textures are rows of values.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.core.table import node_pairs, table_of_values
from urushi.material.layer import DEEPEST
from urushi.material.material import Material
from urushi.material.substrate import Substrate
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.below import below
from urushi.mitsuba.reading.grid import nested_objects, varies, varying_textures
from urushi.mitsuba.reading.offers import GGX, offer_of
from urushi.mitsuba.reading.parameters import CHECKS, CoatTextures
from urushi.nets import lobe as lobes
from urushi.nets.weights import Model
from urushi.textures.axes import DEPTH, LINEAR, NODES, REFLECTANCE, WIDTH, Axis

#: Range of a parameter by its scale, where the range of its texture is not known.
RANGES = {
    WIDTH: (MIN_ALPHA, 1.0),
    DEPTH: (0.0, DEEPEST),
    REFLECTANCE: (0.0, 1.0),
    LINEAR: (0.0, 1.0),
}

#: Scales of a coat's parameters. Those of the appearance and the index are none.
COAT = {"alpha": WIDTH, "albedo": LINEAR, "sigma_t": DEPTH, "g": LINEAR}

#: Range of g in which light transport is accurate.
ASYMMETRIES = (-0.95, 0.95)

#: Width below which a lobe stays beside the table of a bottom, which is too coarse for it.
NARROW = 0.0225

#: Bottoms whose tables are computed at once: bounds memory.
BLOCK = 48

#: Points of uv at which a bottom of values is compared, and its greatest relative error there.
COMPARED, TOLERANCE = 256, 2e-3


class Kind(NamedTuple):
    """A BSDF of Mitsuba whose parameters are known."""

    plugin: str
    scales: Mapping[str, str]  # of textures by name
    colours: tuple[str, ...] = ()  # names of textures that have a value for each channel
    numbers: Mapping[str, str] = {}  # names of properties by those of `mi.traverse`
    switches: Mapping[str, tuple] = {}  # values of properties that it does not list


#: By class. `distribution` is read from the description.
KINDS = {
    "SmoothDiffuse": Kind("diffuse", {"reflectance": REFLECTANCE}, ("reflectance",)),
    "RoughConductor": Kind(
        "roughconductor",
        {"alpha": WIDTH, "specular_reflectance": LINEAR},
        ("specular_reflectance",),
    ),
    "RoughPlastic": Kind(
        "roughplastic",
        {"diffuse_reflectance": REFLECTANCE, "specular_reflectance": LINEAR},
        ("diffuse_reflectance", "specular_reflectance"),
        {"alpha": "alpha", "eta": "int_ior"},
        {"nonlinear": (False, True)},
    ),
    "Principled": Kind(
        "principled",
        {"base_color": REFLECTANCE, "roughness": LINEAR, "metallic": LINEAR, "specular": LINEAR,
         "clearcoat": LINEAR, "clearcoat_gloss": LINEAR, "sheen": LINEAR, "flatness": LINEAR},
        ("base_color",),
        {"eta": "eta"},
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Varying:
    """A parameter that varies."""

    axis: Axis
    texture: "mi.Texture"

    def read(self, si, active) -> list:
        """Its value at a surface interaction: one Dr.Jit float, or one of each channel."""
        if not self.axis.own:
            return [self.texture.eval_1(si, active)]
        return spectrum.to_channels(self.texture.eval(si, active))


def varying_parameters(coat: CoatTextures, bottom: "mi.BSDF") -> list[Varying] | None:
    """The parameters of a coat and a bottom that vary; None: axes are not known, or too many.

    Names of the bottom's begin with "bottom.".
    """
    if mi.is_spectral or coat.is_anisotropic or coat.above is not None or coat.coloured:
        return None
    found = []
    for name, texture in coat.textures.items():
        if name == "rotation" or not varies(texture):
            continue
        if name not in COAT or "thickness" in coat.textures:
            return None
        least, most = range_of(texture, COAT[name])
        if name == "g":
            least, most = range_of(texture, LINEAR, ASYMMETRIES)
        own = name != "alpha" and _is_coloured(texture)
        ends = np.array([least, most])
        if name == "alpha":
            ends = np.where((ends >= 0) & (ends < MIN_ALPHA), MIN_ALPHA, ends)
        CHECKS[name](ends, f"{coat.where}: a texel of {name}", any_shape=True)
        found.append(Varying(Axis(name, COAT[name], *ends.tolist(), own), texture))
    surface = _unwrapped(bottom)
    kind = KINDS.get(surface.class_name())
    textures = nested_objects(surface) if varying_textures(surface) else {}
    for name, texture in textures.items():
        if not isinstance(texture, mi.Texture):
            return None
        if not varies(texture):
            continue
        if kind is None or name not in kind.scales:
            return None
        own = name in kind.colours and _is_coloured(texture)
        ends = range_of(texture, kind.scales[name])
        found.append(Varying(Axis(f"bottom.{name}", kind.scales[name], *ends, own), texture))
    found = [x for x in found if x.axis.least < x.axis.most]
    return found if len(found) in NODES else None


def _unwrapped(bsdf: "mi.BSDF") -> "mi.BSDF":
    while bsdf.class_name() == "TwoSidedBRDF":
        bsdf = nested_objects(bsdf)["brdf_0"]
    return bsdf


def _is_coloured(texture: "mi.Texture") -> bool:
    """Whether a texture may have another value in each channel."""
    if mi.is_monochromatic:
        return False
    if not texture.class_name().startswith("BitmapTexture"):
        return True
    data = mi.traverse(texture)["data"]
    return data.shape[-1] != 1


def range_of(
    texture: "mi.Texture", scale: str, whole: tuple[float, float] | None = None
) -> tuple[float, float]:
    """The least and the largest value of a texture, or all that are allowed if it is no bitmap."""
    if not texture.class_name().startswith("BitmapTexture"):
        return RANGES[scale] if whole is None else whole
    data = mi.traverse(texture)["data"].numpy()
    return float(data.min()), float(data.max())


class Bottom:
    """A bottom at rows of values of its varying parameters."""

    def __init__(
        self, model: Model, bottom: "mi.BSDF", coat: CoatTextures, varying: Sequence[Varying]
    ):
        """bottom: as the coat has it nested."""
        self._model, self._coat, self._given = model, coat, below(bottom, coat)
        self._surface = _unwrapped(bottom)
        self._kind = KINDS.get(self._surface.class_name())
        self._varying = [x for x in varying if x.axis.name.startswith("bottom.")]
        self._fixed: dict[str, Any] = {}

    def is_known(self) -> bool:
        """Whether rows of values reflect as the bottom does where it has these values."""
        if not self._varying or any(
            x.texture.class_name() == "MeshAttribute" for x in self._varying
        ):
            return True  # a mesh is needed for others
        assert self._kind is not None  # for the type checker
        rng = np.random.default_rng(0)
        uv, (wi, wo) = rng.random((COMPARED, 2)), (x[::8] for x in self._model.networks.pairs())
        si = spectrum.points(uv)
        values = {x.axis.name: x.read(si, True) for x in self._varying}
        dr.eval(values)
        rows = {
            name: np.stack([np.broadcast_to(x.numpy(), len(uv)) for x in channels])
            for name, channels in values.items()
        }
        f = probing.texel_values(self._given, wi, wo, uv, probing.Averaging())
        for switches in self._switches():
            self._fixed = switches
            same = True
            for channel in range(f.shape[1]):
                own = {n: x[min(channel, len(x) - 1)] for n, x in rows.items()}
                found = self._values(own, wi, wo)[:, channel]
                error = np.abs(found - f[:, channel]).sum() / max(f[:, channel].sum(), 1e-9)
                same &= bool(error < TOLERANCE)
            if same:
                return True
        return False

    def is_grey(self) -> bool:
        """Whether rows of values reflect alike in all channels."""
        ends = np.array(list(product(*((x.axis.least, x.axis.most) for x in self._varying))))
        names = [x.axis.name for x in self._varying]
        f = self._values(dict(zip(names, ends.T, strict=True)), *self._model.networks.pairs())
        return bool(np.allclose(f, f[:, :1], rtol=1e-4))

    def _switches(self) -> Iterator[dict[str, Any]]:
        assert self._kind is not None  # for the type checker
        names = list(self._kind.switches)
        for values in product(*self._kind.switches.values()):
            yield dict(zip(names, values, strict=True))

    def rebuilt(self, rows: Mapping[str, np.ndarray]) -> "mi.BSDF":
        """The BSDF whose varying parameters have rows (k,) of values along u, by their names."""
        kind = self._kind
        assert kind is not None  # for the type checker
        parameters, given = mi.traverse(self._surface), {"type": kind.plugin, **self._fixed}
        given |= nested_objects(self._surface)
        given |= {
            name: float(np.ravel(parameters[key])[0])
            for key, name in kind.numbers.items()
            if key in parameters and key not in given and "specular" not in given
        }
        if kind.plugin == "roughplastic":
            given["ext_ior"] = 1.0
        if "distribution = " in str(self._surface):
            given["distribution"] = "ggx" if GGX in str(self._surface) else "beckmann"
        for name, values in rows.items():
            data = np.asarray(values, np.float32).reshape(1, -1, 1)
            given[name.removeprefix("bottom.")] = {
                "type": "bitmap",
                "bitmap": mi.Bitmap(data),
                "raw": True,
                "filter_type": "nearest",
                "wrap_mode": "clamp",
            }
        return below(mi.load_dict(given), self._coat)

    def _values(self, rows: Mapping[str, np.ndarray], wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """f (k, C, P) of rows at pairs (P, 3)."""
        bsdf, uv = self.rebuilt(rows), along_u(len(next(iter(rows.values()))))
        return probing.texel_values(bsdf, wi, wo, uv, probing.Averaging())

    def substrate(
        self, rows: Mapping[str, np.ndarray], channels: int
    ) -> tuple[Substrate, np.ndarray]:
        """The bottoms of rows (k,) of values, and the place (channels, k) of each among them."""
        own = np.stack([rows[x.axis.name] for x in self._varying])
        different, which = np.unique(own, axis=1, return_inverse=True)
        count = different.shape[1]
        parts = []
        for start in range(0, count, BLOCK):
            some = different[:, start : start + BLOCK]
            names = (x.axis.name for x in self._varying)
            parts.append(self._part(dict(zip(names, some, strict=True)), channels))
        logs, tops = ([*side] for side in zip(*parts, strict=True))
        top = None if tops[0] is None else np.concatenate(tops, axis=1)
        places = np.arange(channels)[:, None] * count + which.ravel()
        if top is not None:
            top = top.reshape(-1, top.shape[-1])
        if logs[0] is None:
            assert top is not None  # for the type checker
            rest = np.tile(self._model.networks.empty_rest(), (len(top), 1))
            codes = np.concatenate([top, rest], axis=1, dtype=np.float32)
            return Substrate.of(Material(codes, self._model)), places
        table = np.concatenate(logs, axis=-1)
        return Substrate.of_logs(table.reshape(*table.shape[:3], -1), top), places

    def _part(
        self, rows: Mapping[str, np.ndarray], channels: int
    ) -> tuple[np.ndarray | None, np.ndarray | None]:
        """Tables (U, V, W, channels, k), and lobes (channels, k, N) beside them.

        No table: they are their lobes; no lobes: they are their tables.
        """
        bsdf, uv = self.rebuilt(rows), along_u(len(next(iter(rows.values()))))
        known, bare = probing.known_lobes(bsdf, uv), offer_of(bsdf).bare
        if known is not None:
            known = np.moveaxis(known[:, :channels], 1, 0)
            if bare:
                known[..., :4] = np.minimum(known[..., :4], 1)
                return None, known
        wi, wo = (w.reshape(-1, 3) for w in node_pairs())
        f = probing.texel_values(bsdf, wi, wo, uv, probing.Averaging())[:, :channels]
        values = np.moveaxis(probing.check_values(f, "the nested BSDF"), 1, 0)
        if known is not None:
            values = np.maximum(values - lobes.f(known[..., None, :], wi, wo), 0)
        table = table_of_values(values.reshape(-1, len(wi)).T)
        return table.reshape(*table.shape[:3], channels, -1), known


def along_u(count: int) -> np.ndarray:
    """Points uv (count, 2) in the middles of a row of texels."""
    return np.stack([(np.arange(count) + 0.5) / count, np.full(count, 0.5)], axis=-1)
