"""The parameters of `layered` and `neural_layered`: a coat's textures and the BSDF under it."""

import copy
from collections.abc import Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.checks import AIR, DEFAULT_COAT, MIN_ALPHA, MIN_INDEX_STEP, CoatParameters, Widths
from urushi.core import appearance, microfacet
from urushi.core.appearance import LOOK, PHYSICAL, look_of
from urushi.core.namespace import DRJIT
from urushi.errors import ParameterError
from urushi.mitsuba import spectrum
from urushi.mitsuba.frames import Turn
from urushi.mitsuba.properties import describe, switch_of
from urushi.mitsuba.reading.grid import varies, varying_textures
from urushi.mitsuba.recording import Recorded, opaque
from urushi.mitsuba.snapshot import has_gradients, is_attached

#: Parameters of a coat that may be textures, and their defaults. The index of refraction is given
#: by two properties of its own.
DEFAULTS = {name: value for name, value in DEFAULT_COAT._asdict().items() if name != "eta"} | {
    "thickness": 1.0
}

#: Parameters that all channels share; widths may differ.
NUMBERS = ("thickness", "rotation")

#: The properties of an anisotropic coat's widths, in place of `alpha`.
TWO_WIDTHS = ("alpha_u", "alpha_v")

#: All properties of a coat, and those of `neural_layered`, which the others ignore.
COAT_PROPERTIES = (
    *(*DEFAULTS, *TWO_WIDTHS, *LOOK, "rotation", "int_ior", "ext_ior", "energy_compensation"),
    *("resolution", "weights"),
)

#: The check of each parameter.
CHECKS = {
    **{name: getattr(checks, name) for name in CoatParameters._fields},
    **dict.fromkeys(TWO_WIDTHS, checks.alpha),
    **dict.fromkeys(LOOK, checks.share),
    "thickness": checks.thickness,
    "rotation": checks.rotation,
}


class Medium(Recorded):
    """A medium of an index of refraction that is a number or a texture."""

    outside = 1.0  # the index relative to air of what `opaque_eta` is relative to

    def __init__(self, index: npt.ArrayLike, texture: "mi.Texture | None" = None):
        """index: relative to air, a number or one per channel; times the texture, if given."""
        self.opaque_eta = (mi.Spectrum if np.ndim(index) else mi.Float)(index)
        self.textures = {} if texture is None else {"int_ior": texture}

    @property
    def has_textured_eta(self) -> bool:
        """Whether the index is a texture, times `opaque_eta`."""
        return "int_ior" in self.textures

    def inside(self, si, active=True) -> Any:
        """The index, relative to air."""
        return self._eta_given(si, active) * self.outside

    def _eta_given(self, si, active) -> Any:
        if not self.has_textured_eta:
            return self.opaque_eta
        return self.opaque_eta * self.textures["int_ior"].eval_1(si, active)

    def put_index(self, callback) -> None:
        """List the index for `mi.traverse`, as that outside of what lies below."""
        if self.has_textured_eta:
            callback.put("ext_ior", self.textures["int_ior"], mi.ParamFlags.Differentiable)
        else:
            callback.put("ext_eta", self.opaque_eta, mi.ParamFlags.Differentiable)


class CoatTextures(Medium):
    """The textures of a coat, read from a plugin's properties, and its relative index `eta`.

    An anisotropic coat has the textures `alpha_u` and `alpha_v` in place of `alpha`, a medium given
    by its appearance those of `LOOK` in place of `albedo` and `sigma_t`. The textures `thickness`
    and `rotation` exist if the properties are given.
    """

    def __init__(self, props: "mi.Properties"):
        """Read the properties."""
        self.where = describe(props)  # begins errors
        defaults = DEFAULTS | look_of(props, f"{self.where}:")
        medium = LOOK if "color" in defaults else PHYSICAL
        alpha, u, v = (props.get(n, None) for n in ("alpha", *TWO_WIDTHS))
        chosen = checks.widths(alpha, u, v, f"{self.where}:", DEFAULTS["alpha"])
        self.widths = TWO_WIDTHS if isinstance(chosen, Widths) else ("alpha",)
        names = [*self.widths, *medium, "g", *(n for n in NUMBERS if n in props)]
        # Widths given as colours or spectra; monochromatic variants read them as numbers.
        colours = (name for name in self.widths if _is_colour(props, name))
        self.coloured = () if mi.is_monochromatic else tuple(colours)
        # By the properties' names
        self.textures = {n: self._texture(props, n, defaults.get(n, 1.5)) for n in names}
        self.compensated = switch_of(props, "energy_compensation")
        self.above: Medium | None = None  # whose medium lies above in place of `ext_ior`
        self._given = "ext_ior" in props
        ext_ior = index_of_refraction(props, "ext_ior", "air", f"{self.where}: ext_ior")
        if not ext_ior > 0:
            raise ParameterError(f"{self.where}: ext_ior is {ext_ior:g}; it must be positive")
        self.outside = ext_ior / AIR  # relative to air
        if abs(self.outside - 1) < checks.MIN_INDEX_STEP:  # vacuum is air
            self.outside = 1.0
        # `opaque_eta`: the index relative to `ext_ior`, or 1 / ext_ior if `int_ior` is textured.
        if "int_ior" in props and props.type("int_ior") == mi.Properties.Type.Object:
            self.textures["int_ior"] = self._texture(props, "int_ior", 1.5)
            self.opaque_eta = opaque(1 / ext_ior)
        else:
            int_ior = index_of_refraction(props, "int_ior", "bk7", f"{self.where}: int_ior")
            ratio = checks.eta(int_ior / ext_ior, f"{self.where}: int_ior / ext_ior")
            self.opaque_eta = opaque(float(ratio))

    def relative_to(self, medium: Medium) -> "CoatTextures":
        """The coat below a medium, maybe that of another coat; itself if `ext_ior` was given.

        Its textures, and the medium's as "ext_ior", are shared.
        """
        if self._given:
            return self
        below = copy.copy(self)
        below.above = medium
        if medium.has_textured_eta:
            below.textures = self.textures | {"ext_ior": medium.textures["int_ior"]}
        return below

    @property
    def index_above(self) -> float:
        """The index above the coat relative to air, which is not textured."""
        if self.above is None:
            return self.outside
        return float(self.above.inside(dr.zeros(mi.SurfaceInteraction3f)).numpy()[0])

    @property
    def indices(self) -> list["mi.Float"]:
        """The constants that `eta` depends on: the coat's own index, and that of the one above."""
        return [x.opaque_eta for x in (self, self.above) if x is not None]

    @property
    def changing_indices(self) -> tuple[bool, bool]:
        """Whether the coat's own index varies or carries gradients, and that of the one above."""

        def changes(medium: Medium | None) -> bool:
            if medium is None:
                return False
            if not medium.has_textured_eta:
                return is_attached(medium.opaque_eta)
            texture = medium.textures["int_ior"]
            return bool(varying_textures(texture)) or has_gradients(texture)

        return changes(self), changes(self.above)

    def evaluate(self, si, active) -> CoatParameters:
        """The coat at a surface interaction: alpha and eta Dr.Jit floats, the others spectra.

        alpha is `Widths` if the coat is anisotropic, and a width is a spectrum if it is `coloured`.
        """
        textures, eta = self.textures, self._eta_given(si, active)
        if self.above is not None:
            eta = eta / self.above.inside(si, active)

        def width(name: str) -> Any:
            texture = textures[name]
            evaluate = texture.eval if name in self.coloured else texture.eval_1
            return evaluate(si, active)

        alpha = alpha_of([*map(width, self.widths)])
        g = textures["g"].eval(si, active)
        if "color" in textures:
            look = (textures[name].eval(si, active) for name in LOOK)
            albedo, sigma_t = appearance.medium(look, g, DRJIT)
        else:
            albedo, sigma_t = (textures[name].eval(si, active) for name in PHYSICAL)
        if "thickness" in textures:
            sigma_t *= textures["thickness"].eval_1(si, active)
        return CoatParameters(alpha, eta, albedo, sigma_t, g)

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters of `at`."""
        return (*self.widths, *CoatParameters._fields[1:])

    def at(self, si, active=True) -> dict[str, list]:
        """The coat at a surface interaction by name; if anisotropic, `TWO_WIDTHS` for alpha.

        Lists of Dr.Jit floats: one for each channel, or one that all channels share.
        """
        alpha, *others = self.evaluate(si, mi.Bool(active))
        values = [*microfacet.pair(alpha)] if self.is_anisotropic else [alpha]
        return {
            name: list(x) if dr.depth_v(x) > 1 else [x]
            for name, x in zip(self.names, [*values, *others], strict=True)
        }

    def numbers(self, uv: np.ndarray) -> dict[str, np.ndarray]:
        """`at` points uv (M, 2), in the bands that materials are read at: float32 (C, M).

        C is one if all channels share a number.
        """
        si = spectrum.points(uv)
        found = self.at(si)
        for name in ("albedo", "sigma_t", "g", *self.coloured) if mi.is_spectral else ():
            found[name] = spectrum.at_bands(si, lambda name=name: self.at(si)[name])
        dr.eval(found)
        rows = {n: [np.broadcast_to(x.numpy(), len(uv)) for x in part] for n, part in found.items()}
        return {name: np.stack(part) for name, part in rows.items()}

    def layering(self, uv: np.ndarray) -> CoatParameters:
        """The coat at points uv (M, 2): alpha and eta (M, 1), the others (M, channels).

        alpha may be `Widths`, and coloured widths are (M, channels). Widths are at least
        `MIN_ALPHA`, as in the walk. The numbers are those that `check_coat` accepts.
        """
        # Six digits: 0.01 in single precision is less than 0.01 in double.
        found = {n: x.T.astype(np.float64).round(6) for n, x in self.numbers(uv).items()}
        eta = found.pop("eta")
        eta = np.where(np.abs(eta - 1) < MIN_INDEX_STEP, 1, eta)
        alpha = [np.maximum(found.pop(name), MIN_ALPHA) for name in self.widths]
        return CoatParameters(alpha_of(alpha), eta, **found)

    @property
    def is_anisotropic(self) -> bool:
        """Whether the coat has the textures `alpha_u` and `alpha_v`."""
        return len(self.widths) == 2

    @property
    def has_rotation(self) -> bool:
        """Whether the tangent is turned."""
        return "rotation" in self.textures

    def turn(self, si, active) -> Turn | None:
        """The turn of the tangent, if there is one."""
        return Turn.of(self.textures["rotation"].eval_1(si, active)) if self.has_rotation else None

    @property
    def constant_rotation(self) -> float | None:
        """The angle of the tangent [degrees]; None: it is a texture, or there is none."""
        texture = self.textures.get("rotation")
        if texture is None or varies(texture):
            return None
        return float(texture.eval_1(dr.zeros(mi.SurfaceInteraction3f)).numpy()[0])

    @property
    def eta(self) -> float:
        """The relative index of refraction, unless it is textured."""
        return float(self.opaque_eta.numpy()[0]) / (self.index_above / self.outside)

    def traverse(self, callback, flags: "mi.ParamFlags") -> None:
        """List the textures and `eta` for `mi.traverse`."""
        for name, texture in self.textures.items():
            callback.put(name, texture, flags)
        if not self.has_textured_eta:
            callback.put("eta", self.opaque_eta, flags)
        if self.above is not None and not self.above.has_textured_eta:
            callback.put("ext_eta", self.above.opaque_eta, flags)

    def parameters_changed(self) -> None:
        """Check `eta`, which `mi.traverse` may have changed."""
        if not self.has_textured_eta:
            checks.eta(self.eta, f"{self.where}: eta")
        dr.make_opaque(self.opaque_eta)

    def __str__(self) -> str:
        texts = {name: str(x).replace("\n", "\n  ") for name, x in self.textures.items()}
        lines = [f"  {name} = {text}" for name, text in texts.items()]
        if not self.has_textured_eta:
            lines.append(f"  eta = {self.eta:g}")
        return ",\n".join(lines)

    def _texture(self, props: "mi.Properties", name: str, default: float) -> "mi.Texture":
        """A property as a texture."""
        kind = props.type(name) if name in props else None
        if mi.is_spectral and kind == mi.Properties.Type.Color:
            color = [float(value) for value in props[name]]
            if min(color) < 0:
                raise ParameterError(
                    f"{self.where}: {name} has a negative channel, which spectral variants cannot "
                    "represent; give one number"
                )
            absorbs = name == "sigma_t" and "albedo" not in props
            read = spectrum.from_depth if absorbs else spectrum.from_color
            texture = mi.load_dict(read(color))
        else:
            try:
                texture = props.get_unbounded_texture(name, default)
            except RuntimeError as error:
                raise ParameterError(
                    f"{self.where}: {name} must be a number, a spectrum or a texture"
                ) from error
        if name in NUMBERS and _is_colour(props, name):
            raise ParameterError(
                f"{self.where}: {name} must be a number or a texture; all channels share it"
            )
        return texture


def alpha_of(widths: Sequence[Any]) -> Any:
    """A width as it is, and two as `Widths`."""
    return widths[0] if len(widths) == 1 else Widths(*widths)


def _is_colour(props: "mi.Properties", name: str) -> bool:
    """Whether a property is given as a colour or spectrum, not as a number or texture."""
    colours = mi.Properties.Type.Color, mi.Properties.Type.Spectrum
    return name in props and props.type(name) in colours


def index_of_refraction(props: "mi.Properties", name: str, default: str, where: str) -> float:
    """The index of refraction that a property gives as a number or by Mitsuba's name of it."""
    value = props.get(name, default)
    if isinstance(value, int | float) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, str):
        what = "texture" if isinstance(value, mi.Texture) else type(value).__name__
        raise ParameterError(f"{where} is a {what}; give a number or the name of a material")
    try:
        glass = mi.load_dict({"type": "dielectric", "int_ior": value, "ext_ior": 1.0})
    except RuntimeError as error:
        names = str(error).rpartition("Valid choices are:")[2]
        raise ParameterError(
            f"{where} is {value!r}; give a number or one of the materials {names}"
        ) from error
    return round(float(np.ravel(mi.traverse(glass)["eta"])[0]), 6)
