"""A material: one latent code per channel, with its basis."""

import os
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from urushi import checks, files
from urushi.checks import CoatParameters
from urushi.core.directions import rotated
from urushi.core.mixture import Mixture
from urushi.core.namespace import NUMPY, components, stacked
from urushi.core.quadrature import EDGE_NODES, directional_albedos
from urushi.core.table import MAX_LOG, MIN_LOG, SHAPE, interpolated
from urushi.errors import FileError, ParameterError
from urushi.export.program import material_text, texture_form
from urushi.export.rest import own_texture
from urushi.nets import lobe as lobes
from urushi.nets import transmittance
from urushi.nets.weights import Model, Weights, find, model_of_file
from urushi.parallel import fill_blocks

#: Version of the files of materials.
FORMAT_VERSION = 3

#: Directions whose albedo is integrated at once, over 1536 others each, or more.
ALBEDO_BLOCK = 16

#: A table has a backward peak if ln f at wo = wi is above ln f at this node of the difference
#: angle, 21 degrees, by more than this. Media without an interface reach 3.5 for g = -0.8.
PEAK_NODE, PEAK = 8, 3.0


class Coating(NamedTuple):
    """How a material was layered: what is needed to layer it again below another medium."""

    coat: CoatParameters  # checked; `eta` is relative to the medium above
    absolute: bool  # whether the coat keeps its index below another medium; otherwise `eta`
    bottom: "Material"  # under the coat
    fast: bool = False  # whether the layering network computed it
    compensated: bool = False  # whether it gives back the light that the surface loses


@dataclass(frozen=True, eq=False)
class Material:
    """A BRDF as latent codes. Make it with `encode`, `layer`, `lerp` or `load`.

    Codes of two widths (`model.widths` is 2) are symmetric about the tangent, the x axis,
    and about the y axis.

    Attributes:
        latents: read-only float32 (C, L), one code per channel (C = 3 for RGB, 1 for grey).
        model: the weights.
        table: read-only float16 (U, V, W, C), ln f over directions (see `urushi.core.table`),
            by which f is evaluated instead of by the latents, as of measured BRDFs. Default: None.
        beside_lobe: whether f is the lobe of the latents plus the table times T(wi) T(wo) of
            `urushi.nets.transmittance`, as of coats; otherwise the table is of all of f. False
            without a table. Default: False.
        rotation: angle [degrees] by which the tangent is turned about the normal,
            counter-clockwise, see `rotated`; 0 for one width. Default: 0.
        coating: its topmost coat, if `layer` made it. Default: None.

    Materials equal each other if codes, tables, rotations and weights do.
    """

    latents: np.ndarray
    model: Model
    table: np.ndarray | None = None
    rotation: float = 0.0
    beside_lobe: bool = False
    coating: Coating | None = None

    def __post_init__(self) -> None:
        latents = _numbers(self.latents, np.float32, "latents")
        channels = max(len(latents), 1) if latents.ndim == 2 else 1
        checked: dict[str, Any] = {
            "latents": _checked(latents, (channels, self.model.arch.latent), "latents"),
            "beside_lobe": bool(self.beside_lobe) and self.table is not None,
            "rotation": _checked_rotation(self.rotation) if self.model.widths == 2 else 0.0,
        }
        if self.table is not None:
            if self.model.widths == 2:
                raise ParameterError("materials of these weights cannot have tables")
            table = _numbers(self.table, np.float16, "tables")
            checked["table"] = _checked(table, (*SHAPE, channels), "tables")
            if not (table.min() >= MIN_LOG and table.max() <= MAX_LOG):
                raise ParameterError(
                    f"a material's tables hold {table.min():g} to {table.max():g}; they are "
                    f"logarithms from {MIN_LOG:g} to {MAX_LOG:g}"
                )
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def __eq__(self, other: object) -> bool:
        return self._key() == other._key() if isinstance(other, Material) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple:
        """What equal materials share."""
        arrays = self.latents, self.table
        contents = (x is not None and (x.shape, (x + 0).tobytes()) for x in arrays)  # -0.0 is 0.0
        return (self.model.fingerprint, *contents, self.beside_lobe, self.rotation)

    def __repr__(self) -> str:
        return f"Material({self.channels} channels, weights {self.model.fingerprint})"

    @property
    def channels(self) -> int:
        """The number of channels, C."""
        return len(self.latents)

    def rotated(self, angle: float) -> "Material":
        """Return the material with its tangent rotated about the normal.

        angle: [degrees], counter-clockwise, added to the present rotation. An isotropic material is
            returned as it is.

        Raises:
            ParameterError: angle is not a finite number.
        """
        angle = _checked_rotation(angle)
        if self.model.widths == 1:
            return self
        return replace(self, rotation=(self.rotation + angle) % 360.0)

    def _inside(self, w: np.ndarray) -> np.ndarray:
        """Directions (N, 3) in the frame of the turned tangent."""
        return w if self.rotation == 0 else rotated(w, -self.rotation / 360.0)

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Evaluate the BRDF.

        Args:
            wi, wo: (N, 3) unit vectors pointing away from the surface; z is the normal.

        Returns:
            float32 (N, C) [1/sr], without cosine: positive, the same bits with wi and wo
            exchanged, and zero where either direction is below the horizon.

        Raises:
            ParameterError: wrong shapes, or directions that are not unit vectors.
        """
        wi, wo = map(self._inside, checks.directions(wi, wo))
        return self._filled(wi, wo)

    def _filled(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        f = np.empty((len(wi), self.channels), np.float32)
        if self.table is not None:
            return fill_blocks(f, self._tabulated, wi, wo)
        each = self.latents[None], wi[:, None], wo[:, None]
        return fill_blocks(f[..., None], self._f, *each)[..., 0]

    def _f(self, z: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        f = self.model.networks.f(z, wi, wo)
        return np.where(_above(wi, wo), f, np.float32(0.0))[..., None]

    def _tabulated(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        assert self.table is not None  # for the type checker
        f = interpolated(self.table, wi, wo)
        if self.beside_lobe:
            lobe, a, b = self.latents[:, : self.model.arch.lobe], wi[:, None], wo[:, None]
            f = transmittance.both_ways(lobe, a, b) * f + lobes.f(lobe, a, b)
        return np.where(_above(wi, wo)[:, None], f, np.float32(0.0))

    def pdf(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Return the density of `sample` at wo given wi: float32 (N,) [1/sr].

        wi, wo: (N, 3) unit vectors. It integrates to one over wo's hemisphere and is zero where
        either direction is below the horizon. All channels share one proposal, of the mean code.

        Raises:
            ParameterError: wrong shapes, or directions that are not unit vectors.
        """
        wi, wo = map(self._inside, checks.directions(wi, wo))

        def density(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
            return self._proposal(wi).pdf(components(wi), components(wo), NUMPY)[:, None]

        return fill_blocks(np.empty((len(wi), 1), np.float32), density, wi, wo)[:, 0]

    def sample(self, wi: npt.ArrayLike, u: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Draw directions wo with a density approximately proportional to f times wo's cosine.

        Args:
            wi: (N, 3) unit vectors.
            u: (N, 3) uniform random numbers in [0, 1).

        Returns:
            (wo, pdf): float32 (N, 3) and (N,); the normal and 0 where wi is below the horizon.

        Raises:
            ParameterError: wrong shapes, directions that are not unit vectors, u out of range.
        """
        wi = self._inside(checks.direction(wi, "wi"))
        u = checks.uniform(u, len(wi))
        rows = fill_blocks(np.empty((len(wi), 4), np.float32), self._sample, wi, u)
        wo = rows[:, :3] if self.rotation == 0 else rotated(rows[:, :3], self.rotation / 360.0)
        return np.ascontiguousarray(wo), np.ascontiguousarray(rows[:, 3])

    def _sample(self, wi: np.ndarray, u: np.ndarray) -> np.ndarray:
        above = wi[:, 2] > 0.0
        normal = np.array([0.0, 0.0, 1.0], np.float32)
        raised = np.where(above[:, None], wi, normal)
        proposal, incident = self._proposal(raised), components(raised)
        drawn = proposal.sample(incident, u[:, 0], u[:, 1:].T, NUMPY)
        wo, pdf = stacked(drawn), proposal.pdf(incident, drawn, NUMPY)
        wo, pdf = np.where(above[:, None], wo, normal), np.where(above, pdf, np.float32(0.0))
        return np.concatenate([wo, pdf[:, None]], axis=1)

    def _proposal(self, wi: np.ndarray) -> Mixture:
        return self.model.networks.proposal(self.latents.mean(axis=0)[None], wi)

    def directional_albedo(self, wi: npt.ArrayLike) -> np.ndarray:
        """Integrate f times wo's cosine over the hemisphere: the directional albedo.

        wi: (N, 3) unit vectors. Returns float32 (N, C), zero where wi is below the horizon. It is
            computed by a fixed quadrature of 1536 directions per wi, with an error of about 0.001;
            of four times as many for anisotropic materials, and again for indices below one and
            for backward peaks of media, of g down to -0.95.

        Raises:
            ParameterError: wrong shape, or directions that are not unit vectors.
        """
        wi = self._inside(checks.direction(wi, "wi"))
        albedo = np.zeros((len(wi), self.channels), np.float32)
        above = np.flatnonzero(wi[:, 2] > 0.0)
        polar = transmittance.polar_nodes(self.latents[:, : self.model.arch.lobe])
        if self.table is not None and (self.table[:, 0] - self.table[:, PEAK_NODE]).max() > PEAK:
            polar = EDGE_NODES
        for start in range(0, len(above), ALBEDO_BLOCK):
            rows = above[start : start + ALBEDO_BLOCK]
            albedo[rows] = directional_albedos(
                self._filled, wi[rows], anisotropic=self.model.widths == 2, polar=polar
            )
        return albedo

    def shader(self, language: str, prefix: str = "urushi") -> str:
        """Return the material as source code: functions f, pdf and sample in one file.

        f reads the rest beside its lobe from the texture `shader_texture`. See `urushi export`.

        Args:
            language: "glsl", "wgsl", "hlsl", "slang", "osl" or "python".
            prefix: begins the names of functions and structures; names in Python have none.

        Raises:
            ParameterError: the language is unknown, the prefix is not a name, or the material has
                neither one nor three channels.
        """
        return material_text(
            language,
            self.model,
            self.latents,
            prefix,
            self.rotation,
            has_lobe=self.table is None or self.beside_lobe,
            has_rest=self._table() is not None,
        )

    def shader_texture(self, language: str = "glsl") -> np.ndarray | None:
        """Return the texture of ln f that `shader`'s code reads; None if f is the lobe alone.

        Returns:
            float16 (depth, height, width, 4), or (height, width, 3) for "osl".

        Raises:
            ParameterError: the language is unknown.
        """
        table = self._table()
        return None if table is None else own_texture(table, texture_form(language))

    def logs(self) -> np.ndarray:
        """Return ln f at the nodes of `urushi.core.table`: (U, V, W, C), by table or codes.

        Codes without a rest have the least logarithm everywhere. Beside a lobe it is ln of the
        rest, without T (see `beside_lobe`).
        """
        table = self._table()
        return np.full((*SHAPE, self.channels), MIN_LOG) if table is None else table

    def _table(self) -> np.ndarray | None:
        """The table, or that of the codes (..., C); None if they have no rests."""
        return self.model.networks.table(self.latents) if self.table is None else self.table

    def save(self, path: str | os.PathLike) -> None:
        """Write the material to a safetensors file; `urushi.load` reads it.

        The file holds the codes, the table if there is one, and the fingerprint of the weights,
        not the weights.

        Raises:
            FileError: the file cannot be written.
        """
        description, arrays = _contents(self)
        description |= {"version": FORMAT_VERSION, "weights": self.model.fingerprint}
        files.write_tensors(path, "material", description, arrays)


def load(path: str | os.PathLike, weights: Weights | None = None) -> Material:
    """Read a material that `Material.save` wrote.

    weights: those with which it was encoded, a Model or a file; by default, the shipped
        ones of its fingerprint.

    Raises:
        FileError: missing, truncated, foreign, damaged, or made with other weights.
    """
    description, arrays = files.read_tensors(path, "material", FORMAT_VERSION)
    given = None if weights is None else find(weights)
    model = model_of_file(path, description.get("weights"), given)
    try:
        return _material(description, arrays, model)
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        reason = f"it has no {error}" if isinstance(error, KeyError) else error
        raise FileError(
            f"the material file '{path}' is damaged: {reason}; copy or write it again"
        ) from error


def _contents(material: Material) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The description and the arrays by which a file holds a material and those under its coats."""
    description: dict[str, Any] = {"rotation": material.rotation} if material.rotation else {}
    arrays = {"latents": material.latents}
    if material.table is not None:
        arrays["table"] = material.table
        description["beside_lobe"] = material.beside_lobe
    if material.coating is not None:
        coat, absolute, bottom, fast, compensated = material.coating
        arrays["coat"] = np.stack(np.broadcast_arrays(*map(np.atleast_1d, coat.columns())))
        below, others = _contents(bottom)
        description |= {"absolute": absolute, "fast": fast, "bottom": below}
        description |= {"compensated": True} if compensated else {}
        arrays |= {f"bottom.{name}": array for name, array in others.items()}
    return description, arrays


def _material(description: dict[str, Any], arrays: dict[str, np.ndarray], model: Model) -> Material:
    """The inverse of `_contents`."""
    for name, array in arrays.items():
        if array.dtype.kind != "f":
            raise ValueError(f"its {name} are of type {array.dtype}, not of floating point")
    coating = None
    if "coat" in arrays:
        coat = checks.coat(CoatParameters.of_columns(arrays["coat"]), "the coat's", any_shape=True)
        if model.widths == 1:
            checks.one_width(coat.alpha, "the coat's")
        prefix = "bottom."
        below = {n.removeprefix(prefix): x for n, x in arrays.items() if n.startswith(prefix)}
        bottom = _material(description["bottom"], below, model)
        (count,) = np.broadcast_shapes(arrays["coat"].shape[1:], (bottom.channels,))
        if len(arrays["latents"]) not in (count, bottom.channels):  # absent coats change nothing
            raise ValueError(f"its coat and bottom have {count} channels, its latents do not")
        absolute, fast = bool(description["absolute"]), bool(description.get("fast"))
        compensated = bool(description.get("compensated"))
        coating = Coating(coat, absolute, bottom, fast, compensated)
    return Material(
        arrays["latents"],
        model,
        arrays.get("table"),
        description.get("rotation", 0.0),
        bool(description.get("beside_lobe")),
        coating,
    )


def _numbers(values: npt.ArrayLike, dtype: Any, what: str) -> np.ndarray:
    """A copy of numbers as an array of a type; what: their name in errors."""
    try:
        with np.errstate(over="ignore"):
            return np.array(checks.real(values, dtype))
    except checks.NO_NUMBERS as error:
        raise ParameterError(f"a material's {what} must be an array of real numbers") from error


def _checked(array: np.ndarray, shape: tuple[int, ...], what: str) -> np.ndarray:
    """The array, of finite numbers and now read-only; what: its name in errors."""
    if array.shape != shape:
        raise ParameterError(f"a material's {what} have the shape {array.shape}; give {shape}")
    if not np.isfinite(array).all():
        raise ParameterError(f"a material's {what} hold a number that is not finite")
    array.flags.writeable = False
    return array


def _checked_rotation(angle: float) -> float:
    """An angle in degrees."""
    found = checks.rotation(angle, "a material's rotation")
    if found.ndim:
        raise ParameterError("a material's rotation must be one number, which all channels share")
    return float(found)


def _above(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Whether both directions (..., 3) are above the horizon."""
    return (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
