"""The parameters of the plugin `openpbr`, as textures, and textures that are computed from them."""

import copy
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from functools import partial
from typing import Any, ClassVar

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import Widths
from urushi.core.namespace import DRJIT
from urushi.errors import ParameterError
from urushi.mitsuba import spectrum
from urushi.mitsuba.frames import Turn
from urushi.mitsuba.properties import describe
from urushi.mitsuba.reading.grid import varies
from urushi.mitsuba.recording import Recorded
from urushi.openpbr_surface import formulas
from urushi.openpbr_surface.parameters import PARAMETERS, checked, parameter

#: Properties of the plugin that are no parameters of the specification.
OPTIONS = (
    *("reference", "unsupported", "energy_compensation", "interior", "resolution", "weights"),
    "origin",
)

#: Colours of light that has crossed a medium or a surface, and how often it does, where it is seen:
#: twice through the surface of a body. Their spectra are exact for this number of crossings.
CROSSINGS = {"coat_color": 1, "transmission_color": 2}


class Values:
    """Numbers and colours at a surface interaction, within their ranges: attributes by name."""

    def __init__(self, inputs: "Inputs", si, active):
        self._inputs, self._lanes = inputs, (si, active)

    def __getattr__(self, name: str) -> Any:
        texture = self._inputs.textures[name]
        read = texture.eval if PARAMETERS[name].kind == "color" else texture.eval_1
        return clipped(name, read(*self._lanes))

    def of(self, *names: str) -> list:
        """The values of several."""
        return [getattr(self, name) for name in names]

    def widths(self, layer: str) -> Any:
        """The GGX width of a layer, "coat" or "specular", or the two `Widths`."""
        names = f"{layer}_roughness", f"{layer}_roughness_anisotropy"
        if self._inputs.is_constant(names[1], 0):
            return formulas.lobe_width(getattr(self, names[0]), DRJIT)
        rough, bias = self.of(*names)
        return Widths(*formulas.lobe_widths(rough, bias, DRJIT))


class Inputs(Recorded):
    """All parameters except the directions, as textures; numbers and colours are textures too."""

    UNRECORDED: ClassVar = ("_relied",)

    def __init__(self, props: "mi.Properties", *, emits: bool = False):
        """Read the properties.

        emits: whether they are an emitter's, which refuses no unsupported features.
        """
        # Begins errors: the plugin's name, or the document that `materialx` read.
        self.where = describe(props)
        unsupported = props.get("unsupported", "error")
        if unsupported not in ("error", "ignore"):
            raise ParameterError(
                f'{self.where}: unsupported is "{unsupported}"; give "error" or "ignore"'
            )
        self.textures: dict[str, mi.Texture] = {}  # by the parameters' names
        # Parameters that are given as numbers, or as bitmaps of one value. A number that is changed
        # later counts as a texture from then on, see `refresh`.
        self.constants: dict[str, Any] = {}
        self.maps: dict[str, mi.Texture] = {}  # of directions
        # Whether the shape has the medium inside of the material, which a BSDF does not hold.
        self.interior = bool(props.get("interior", False))
        self._numbers: list[str] = []  # parameters that are given as numbers
        self._relied: dict[str, np.ndarray] = {}  # values of textures when `known` returned them
        # First, because colours depend on it.
        for name in sorted(props.keys(), key=lambda name: name != "geometry_thin_walled"):
            if name not in OPTIONS:
                unbounded = props.type(name) == mi.Properties.Type.Spectrum
                self._read(name, props.get_unbounded_texture(name) if unbounded else props[name])
        for name, entry in PARAMETERS.items():
            if entry.kind in ("float", "color") and name not in self.textures:
                self._constant(name, checked(name, entry.default))
        for problem, cure, instead in () if emits else self._unsupported():
            problem = f"{self.where}: {problem}"
            if unsupported == "error":
                raise ParameterError(f'{problem}; {cure}, or set unsupported to "ignore"')
            mi.Log(mi.LogLevel.Warn, f"{problem}; {instead}")

    @classmethod
    def of(cls, values: Mapping[str, Any], origin: str) -> "Inputs":
        """The parameters of numbers, colours as tuples, and textures as Mitsuba's dictionaries.

        origin: begins errors.
        """
        props = mi.Properties("openpbr")
        props["origin"] = origin
        for key, value in values.items():
            value = mi.load_dict(value) if isinstance(value, dict) else value
            props[key] = mi.ScalarColor3f(value) if isinstance(value, tuple) else value
        return cls(props)

    @property
    def thin(self) -> bool:
        """Whether the surface is a sheet without an inside."""
        return bool(self.constants.get("geometry_thin_walled", False))

    def transmits(self, weight: str) -> bool:
        """Whether the share that a weight gives of a base that is no metal transmits light."""
        left_out = self.is_constant("base_metalness", 1) or (
            weight == "subsurface_weight" and self.is_constant("transmission_weight", 1)
        )
        return not (left_out or self.is_constant(weight, 0))

    def replaced(self, values: Mapping[str, Any]) -> "Inputs":
        """The same with other numbers, colours or textures, by name."""
        other = copy.copy(self)
        other.textures, other.constants = dict(self.textures), dict(self.constants)
        other._numbers, other._relied = list(self._numbers), {}
        for name, value in values.items():
            other.constants.pop(name, None)
            other._numbers = [x for x in other._numbers if x != name]
            if isinstance(value, mi.Texture):
                other.textures[name] = value
            else:
                other._constant(name, checked(name, value))
        return other

    def with_textures(self, replacement: Callable[["mi.Texture"], "mi.Texture"]) -> "Inputs":
        """The same with other textures; replacement: from each to the new one, maybe itself."""
        found = {name: replacement(texture) for name, texture in self.textures.items()}
        return self.replaced({n: x for n, x in found.items() if x is not self.textures[n]})

    def is_constant(self, name: str, value: float) -> bool:
        """Whether a parameter is given as this number, and not as a texture."""
        known = self.known(name)
        return known is not None and bool(np.all(known == value))

    def known(self, name: str) -> Any:
        """The value of a parameter that is given as a number; None for a texture.

        A caller may leave out code because of the value: `refresh` reports when it changes.
        """
        if name not in self.constants:
            return None
        if name not in self._relied:
            self._relied[name] = _texture_value(self.textures[name])[0]
        return self.constants[name]

    def is_uniform(self, name: str) -> bool:
        """Whether a parameter is now the same everywhere."""
        return not varies(self.textures[name])

    def middle(self, name: str) -> float:
        """The present value of a number in the middle of uv."""
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.uv = mi.Point2f(0.5)
        with dr.suspend_grad():
            return float(getattr(self.at(si, mi.Bool(True)), name).numpy()[0])

    def refresh(self) -> bool:
        """Whether numbers that `known` has returned have changed or have gradients now.

        These parameters count as textures from then on: the caller must make the parts that it left
        out because of them.
        """
        for name in self._numbers:
            value = _texture_value(self.textures[name])[0].ravel()
            if not (mi.is_spectral and PARAMETERS[name].kind == "color"):  # they are coefficients
                checked(name, value if len(value) == 3 else value.item(), self.where)
        found = {name: _texture_value(self.textures[name]) for name in self._relied}
        changed = [
            name
            for name, (value, differentiated) in found.items()
            if differentiated or not np.array_equal(value, self._relied[name])
        ]
        for name in changed:
            del self._relied[name], self.constants[name]
        return bool(changed)

    def at(self, si, active) -> "Values":
        """The values at a surface interaction."""
        return Values(self, si, active)

    def _read(self, name: str, value: Any) -> None:
        entry = parameter(name, self.where, OPTIONS)
        if entry.kind == "vector":
            if not isinstance(value, mi.Texture):
                checked(name, value, self.where)  # the error says what to give
            self.maps[name] = value
        elif isinstance(value, mi.Texture):
            if entry.kind == "boolean":
                raise ParameterError(
                    f"{self.where}: {name} cannot be a texture; give true or false"
                )
            self.textures[name] = value
            if entry.kind == "float" and not varies(value):
                self.constants[name] = self.middle(name)
        else:
            channels = [float(x) for x in value] if isinstance(value, mi.ScalarColor3f) else value
            self._constant(name, checked(name, channels, self.where))

    def _constant(self, name: str, value: Any) -> None:
        self.constants[name] = value
        kind = PARAMETERS[name].kind
        if kind in ("float", "color"):
            self._numbers.append(name)
        if kind == "float":
            self.textures[name] = mi.load_dict({"type": "uniform", "value": value})
        elif kind == "color":
            color = {"type": "srgb", "color": mi.ScalarColor3f(value.tolist()), "unbounded": True}
            if mi.is_spectral and name in CROSSINGS:
                color = spectrum.from_color(value, power=1 if self.thin else CROSSINGS[name])
            self.textures[name] = mi.load_dict(color)

    def _unsupported(self) -> Iterator[tuple[str, str, str]]:
        """What the BSDF lacks: the problem, its cure, and what happens where it is ignored."""
        absent = partial(self.is_constant, value=0)
        clear, scatters = self.transmits("transmission_weight"), self.transmits("subsurface_weight")
        transmits = clear or scatters
        filmed = transmits and (clear if self.thin else not absent("coat_weight"))
        for name, lacks, feature in (
            ("transmission_dispersion_scale", clear and not self.thin, "dispersion"),
            ("fuzz_weight", transmits, "fuzz over a base that transmits light"),
            ("coat_weight", scatters and self.thin, "a coat on a thin wall that scatters light"),
            ("thin_film_weight", filmed, "a thin film inside of what transmits light"),
        ):
            if lacks and not absent(name):
                problem = f"{name} needs {feature}, which the plugin does not support"
                yield problem, "leave it out", "it is left out"
        deep = clear and not (
            absent("transmission_depth")
            or (self.is_constant("transmission_color", 1) and absent("transmission_scatter"))
        )
        for name, lacks in (("transmission_depth", deep), ("subsurface_weight", scatters)):
            if lacks and not (self.thin or self.interior):
                problem = f"{name} asks for the medium inside of a body, and a BSDF has none"
                on_shape = "the interior of urushi.openpbr(...).on(shape), and set interior to true"
                yield problem, f"give its shape {on_shape}", "its colour is the surface's"
        if not absent("emission_luminance"):
            problem = "emission_luminance asks for emitted light, and a BSDF does not emit"
            cure = "give its shape the emitter 'openpbr_emission' and leave it out here"
            yield problem, cure, "it is left out"
        for kind in ("normal", "tangent"):
            base, coat = f"geometry_{kind}", f"geometry_coat_{kind}"
            if coat not in self.maps or absent("coat_weight"):
                continue
            if kind == "tangent" and absent("coat_roughness_anisotropy"):
                continue  # the coat has no tangent
            if kind == "tangent" and absent("specular_roughness_anisotropy"):
                self.maps[base] = self.maps[coat]  # nor has the base
            if base not in self.maps or not _equal_textures(self.maps[base], self.maps[coat]):
                problem = f"{coat} differs from {base}, and all layers share one frame"
                yield problem, "give both the same", "the coat has the base's"

    def traverse(self, callback, names: Iterable[str], fixed: Container[str] = ()) -> None:
        """List parameters for `mi.traverse`; fixed: those without derivatives."""
        for name in names:
            differentiable = mi.ParamFlags.Differentiable
            flags = mi.ParamFlags.NonDifferentiable if name in fixed else differentiable
            callback.put(name, self.textures[name], flags)

    def turn(self, si, active) -> Turn | None:
        """The turn from the shape's tangent to the map's; None: there is no map."""
        if "geometry_tangent" not in self.maps:
            return None
        x, y = (2 * c - 1 for c in self.maps["geometry_tangent"].eval_3(si, active)[:2])
        size2 = x * x + y * y
        known = size2 > 1e-12
        scale = dr.rsqrt(dr.select(known, size2, 1))
        return Turn(dr.select(known, y * scale, 0), dr.select(known, x * scale, 1))


def _texture_value(texture: "mi.Texture") -> tuple[np.ndarray, bool]:
    """The parameter of a texture of one value, and whether it has gradients enabled."""
    parameters = mi.traverse(texture)
    value = next(parameters[x] for x in ("value", "values", "data") if x in parameters)
    return np.array(dr.detach(value)), bool(dr.grad_enabled(value))


def _equal_textures(one: "mi.Texture", other: "mi.Texture") -> bool:
    """Whether two textures have the same parameters."""
    first, second = ({key: np.array(x) for key, x in mi.traverse(y)} for y in (one, other))
    return first.keys() == second.keys() and all(
        np.array_equal(value, second[key]) for key, value in first.items()
    )


def clipped(name: str, value: Any) -> Any:
    """A value of a texture within the range of a parameter; has gradients at its ends."""
    entry, kind = PARAMETERS[name], type(value)  # a selection of spectra is an array
    value = dr.select(value < entry.low, entry.low, value)
    return kind(value if entry.high == np.inf else dr.select(value > entry.high, entry.high, value))
