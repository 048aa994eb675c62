"""Codes of a coat over a Mitsuba BSDF: constant, or over axes.

Parameters that vary or carry gradients are axes. A bottom of an unknown kind that varies has the
axes u and v, with a node for each texel. An update bakes again what has changed.
"""

from collections.abc import Mapping, Sequence

import drjit as dr
import mitsuba as mi
import numpy as np
from tqdm import tqdm

from urushi import checks
from urushi.checks import MIN_INDEX_STEP, CoatParameters
from urushi.errors import ParameterError
from urushi.material.coated_values import coated_values
from urushi.material.layer import check_ratios, layer_material
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.axes import AxisLatents
from urushi.mitsuba.latents.bottoms import (
    BottomRows,
    along_u,
    probed_codes,
    wavelengths_of,
)
from urushi.mitsuba.latents.codes import ConstantLatents
from urushi.mitsuba.reading.axes import (
    NANOMETRES,
    WAVELENGTH,
    Varying,
    check_coat,
    texel_axes,
    varying_parameters,
    wavelengths_varying,
)
from urushi.mitsuba.reading.grid import check_normals, not_over_uv, varying_textures
from urushi.mitsuba.reading.joined import agree, joined
from urushi.mitsuba.reading.parameters import CoatTextures
from urushi.mitsuba.snapshot import writable
from urushi.nets.weights import Model
from urushi.textures.axes import AXES, FAINT, Axis, Baked, Rows, bake
from urushi.textures.layering import layer_rows, transported_rests
from urushi.textures.store import MIDDLE, TexelGrid, Texture

#: Texels per side of what is no bitmap, the least and the largest side that is chosen, and texels
#: that are read at once.
PROCEDURAL, LEAST, LARGEST, BLOCK = 256, 64, 512, 1 << 13

#: Parts of the spectrum in which a material's changes with the wavelength are found.
WAVELENGTHS = 128

#: Seconds before progress is shown, and between two reports.
PROGRESS_DELAY = 3.0

#: Points that are tested for the wavelengths on which a coat depends.
POINT = np.full((1, 2), 0.5)

Latents = ConstantLatents | AxisLatents


class Baker:
    """The codes of a coat over a bottom; `update` computes them, and again after a change."""

    def __init__(
        self,
        model: Model,
        coat: CoatTextures,
        bottom: "mi.BSDF",
        below: "mi.BSDF",
        resolution: int,
    ):
        """Prepare a coat; nothing is evaluated before `update`.

        bottom: as the coat has it nested. below: as it reflects below the coat. resolution: texels
        per side, 0 to choose.
        """
        self.model, self._coat, self._bottom, self.below = model, coat, bottom, below
        self._resolution = resolution
        self._last: AxisLatents | None = None
        self._fixed: list[np.ndarray] = []  # numbers on which the last one depends
        self._led: list[Varying] = []  # its parameters that follow others
        self.absorbs = False  # whether the coat has no interface and does not scatter, anywhere

    def update(self) -> Latents:
        """The codes for the current parameters."""
        check_normals(self._bottom, self._coat.where)
        check_coat(self._coat)
        rows = BottomRows(self.model, self._bottom, self._coat, self.below)
        known = None if not isinstance(rows.nested, AxisLatents) else rows.nested.varying
        varying = varying_parameters(self._coat, self._bottom, [] if rows.grid else known)
        varying = joined(varying)
        names = {x.axis.name for x in varying}
        with dr.suspend_grad():
            si = spectrum.points(POINT)
            coat = self._coat.at(si)
            same = np.abs(coat["eta"][0].numpy() - 1) < MIN_INDEX_STEP
            clear = not names & {"eta", "albedo"} and bool(same.all())
            self.absorbs = clear and all((x.numpy() == 0).all() for x in coat["albedo"])
            if not (varying or rows.grid):
                return self._constant(rows)
            found = None
            if not (rows.grid or self._coat.coloured):
                found = self._over_parameters(rows, varying)
            return self._over_texels(rows) if found is None else found

    def _constant(self, rows: BottomRows) -> ConstantLatents:
        with spectrum.reading_at(spectrum.FINE):
            coat, bottom = self._coat.layering(POINT), rows.material()
            columns = [column[0] for column in coat.columns()]
            return ConstantLatents(layer_material(CoatParameters.of_columns(columns), bottom))

    def _over_parameters(self, rows: BottomRows, varying: list[Varying]) -> AxisLatents | None:
        """The codes along the parameters that vary; None: the bottom is unknown, or too many
        vary."""
        constants, led = [x for x in varying if x.steps], [x for x in varying if x.leader]
        varying = [x for x in varying if not (x.steps or x.leader)]
        if len(varying) > AXES:
            return None
        axes, fixed = [x.axis for x in varying], self._numbers([*varying, *led], rows)
        fixed += [np.array([ord(c) for x in constants for c in x.axis.name])]
        last = self._last
        alike = len(led) == len(self._led) and all(map(agree, self._led, led))
        if last is not None and alike and self._are_known(axes, fixed, last):
            count, every = len(last.baked.axes), [*varying, *constants]
            former = [x.texture for x in (*last.varying[: len(axes)], *last.varying[count:])]
            gradients = any(x.differentiable for x in every)
            if gradients == last.differentiable and former == [x.texture for x in every]:
                return last
            parts = zip(varying, last.baked.axes, strict=False)
            kept = [x._replace(axis=axis) for x, axis in parts]
            kept += [*last.varying[len(varying) : count], *constants]
            self._last = AxisLatents(last.baked, kept)
            return self._last
        rows.follow([*varying, *led, *constants])
        if not rows.is_known():
            return None
        coated = _Coated(self.model, self._coat, rows, varying, led, constants)
        if coated.needs_wavelengths:
            varying = [*varying, coated.with_wavelengths()]
            if len(varying) > AXES:
                return None
        steps = {x.axis.name: x.steps for x in constants if x.steps is not None}
        material = Rows(coated.coats, coated.rests)
        baked = bake(self.model, [x.axis for x in varying], material, steps)
        self._last = AxisLatents(baked, [*varying, *constants])
        self._fixed, self._led = fixed, led
        return self._last

    def _are_known(self, axes: Sequence[Axis], fixed: list[np.ndarray], last: AxisLatents) -> bool:
        """Whether axes lie within the last ones, and nothing else has changed."""
        names = {axis.name for axis in axes}
        former = [axis for axis in last.baked.axes if axis.name in names | {WAVELENGTH}]
        return (
            len(former) == len(last.baked.axes)
            and [x.name for x in axes] == [x.name for x in former][: len(axes)]
            and all(old.contains(new) for old, new in zip(former, axes, strict=False))
            and len(fixed) == len(self._fixed)
            and all(map(np.array_equal, fixed, self._fixed))
        )

    def _numbers(self, varying: Sequence[Varying], rows: BottomRows) -> list[np.ndarray]:
        """What codes along the axes depend on beside them."""
        names = {x.axis.name for x in varying}
        with spectrum.reading_at(spectrum.FINE):
            coat = self._coat.channels(spectrum.points(POINT))
            numbers = [x.numpy() for name in coat if name not in names for x in coat[name]]
        if isinstance(rows.nested, AxisLatents):
            return [*numbers, np.array([id(rows.nested.baked)])]
        left_out = {id(x.texture) for x in varying}
        parameters = mi.traverse(self._bottom)
        for key, value in writable(self._bottom):
            owner = parameters.properties[key][2]
            if id(owner) not in left_out:
                numbers.append(np.array(getattr(value, "matrix", value)))
        return numbers

    def _over_texels(self, rows: BottomRows) -> AxisLatents:
        """The codes at texels over the unit square of uv, which repeats."""
        coat, bottom = self._coat, rows.bsdf
        parts = [*coat.textures.values(), bottom]
        _check_over_uv(
            parts,
            coat.where,
            f"the nested '{bottom.class_name()}' is evaluated over uv; give textures over uv, or "
            "use the plugin 'layered', which evaluates every point",
        )
        grid = grid_of(parts, self._resolution, rows.grid or MIDDLE)
        texels, left = [], set[str]()
        with _progress(grid, coat.where) as bar:
            for start in range(0, grid.texels, BLOCK):
                uv = grid.uv(start, min(start + BLOCK, grid.texels))
                z = probed_codes(self.model, bottom, uv, coat.where)
                own = coat.layering(uv)
                left |= checks.outside_training(own)
                columns = [np.broadcast_to(x, z.shape[:2])[..., None] for x in own.columns()]
                texels.append(np.concatenate([z, *columns], axis=-1, dtype=np.float32))
                bar.update(len(uv))
        checks.warn_of_training(left, f"{coat.where}:")
        whole = np.concatenate(texels)
        flat = whole.reshape(-1, whole.shape[-1])
        different, index = np.unique(flat, axis=0, return_inverse=True)
        codes = layer_rows(self.model, different)[index.reshape(whole.shape[:2])]
        return AxisLatents(Baked.of_texels(self.model, codes, grid), texel_axes(grid))


class _Coated:
    """A coat over a bottom at rows of values."""

    def __init__(
        self,
        model: Model,
        coat: CoatTextures,
        rows: BottomRows,
        varying: Sequence[Varying],
        led: Sequence[Varying],
        constants: Sequence[Varying],
    ):
        """led: those that follow others. constants: those that change."""
        self._model, self._coat, self._rows = model, coat, rows
        self._names, self._varying = [x.axis.name for x in varying], varying
        self._led = {x.axis.name: x.leader for x in led if x.leader is not None}
        self._changing = [x.axis.name for x in constants]
        self._places = next((x.places for x in varying if x.places is not None), None)
        with spectrum.reading_at(spectrum.FINE):
            own = coat.channels(spectrum.points(POINT))
            fixed = [own[name] for name in own if name not in (*self._names, *self._led)]
            parts = [[x.numpy() for x in part] for part in fixed]
        same = all(np.array_equal(x, part[0]) for part in parts for x in part)
        grey = same and rows.is_grey()
        self.needs_wavelengths = bool(mi.is_spectral) and not grey and WAVELENGTH not in self._names
        self._channels = 1 if grey or mi.is_spectral else spectrum.channel_count()

    def with_wavelengths(self) -> Varying:
        """Follow the wavelength as one more parameter."""
        count = WAVELENGTHS
        middle = np.array([[x.axis.values(np.array(0.5)) for x in self._varying]])
        middle = np.append(middle, np.zeros((1, len(self._changing))), axis=1)
        named = self._named(np.repeat(middle, count + 1, axis=0))
        named[NANOMETRES] = np.linspace(*spectrum.ENDS, count + 1)
        changes = self._rows.spectral_changes(count, named)
        for column in self._columns(named, count + 1):
            changes = changes + np.abs(np.diff(column[0]))
        found = wavelengths_varying(changes)
        self._places = found.places
        self._names.append(WAVELENGTH)
        return found

    def _named(self, values: np.ndarray) -> dict[str, np.ndarray]:
        named = dict(zip([*self._names, *self._changing], values.T, strict=True))
        named |= {name: leader.at(named[leader.name]) for name, leader in self._led.items()}
        if self._places is not None:
            even = np.linspace(*spectrum.ENDS, len(self._places))
            named[NANOMETRES] = np.interp(named[WAVELENGTH], self._places, even)
        return named

    def coats(self, values: np.ndarray) -> CoatParameters:
        """See `Rows`."""
        alpha, *others = self._columns(self._named(values), len(values))
        if self._coat.is_anisotropic:
            return CoatParameters(checks.Widths(alpha, others[0]), *others[1:])
        wide = checks.Widths(alpha, alpha) if self._model.widths == 2 else alpha
        return CoatParameters(wide, *others)

    def _columns(self, named: Mapping[str, np.ndarray], count: int) -> list[np.ndarray]:
        """The coats' parameters (C, count)."""
        with wavelengths_of(named, count):
            found = self._coat.channels(spectrum.points(along_u(count)))
            dr.eval(found)
        columns = []
        for name in self._coat.names:
            is_given = name in self._names or name in self._led
            rows = [named[name]] if is_given else [x.numpy() for x in found[name]]
            rows = [np.broadcast_to(x, count) for x in rows][: self._channels]
            column = np.asarray(rows, np.float64)
            if name in self._changing:
                column = column + named[name]
            if name == "eta":
                column = np.where(np.abs(column - 1) < MIN_INDEX_STEP, 1, column)
            columns.append(np.broadcast_to(column, (self._channels, count)))
        return columns

    def rests(self, values: np.ndarray) -> np.ndarray:
        """See `Rows`."""
        model, named, coat = self._model, self._named(values), self.coats(values)
        flat = np.stack([x.ravel() for x in coat.columns()]).astype(np.float64)
        if model.widths == 1:
            below, places = self._rows.substrate(named, self._channels)
            pairs = model.networks.pairs()
            rest = coated_values(below, places.ravel(), flat[:2], flat[2:], *pairs).T
        else:
            z = self._rows.codes(named, self._channels)
            bottoms = np.broadcast_to(z, (self._channels, *z.shape[1:])).reshape(-1, z.shape[-1])
            check_ratios(model, bottoms, coat)
            rest = transported_rests(model, bottoms, CoatParameters.of_columns(flat))
        return (rest + np.float32(FAINT)).reshape(self._channels, len(values), -1)


def grid_of(parts: Sequence["mi.Object"], resolution: int, least: TexelGrid = MIDDLE) -> TexelGrid:
    """Texels over the unit square of uv.

    Args:
        parts: scene objects with textures.
        resolution: texels of each side, 0 for those of the textures.
        least: it has at least as many texels as this.
    """
    if resolution:
        return TexelGrid(resolution, resolution)
    sizes = [tuple(x.resolution()) for part in parts for x in varying_textures(part)]
    sides = [x if x[0] * x[1] > 1 else (PROCEDURAL, PROCEDURAL) for x in sizes]
    found = np.max([*sides, least[:2]], axis=0)
    # Small bitmaps are magnified: each of their texels has several.
    width, height = (min(side * -(-LEAST // side), LARGEST) for side in found.tolist())
    return TexelGrid(width, height)


def at_texels(latents: AxisLatents, resolution: int, where: str) -> tuple[Texture, TexelGrid]:
    """Codes over axes as a texture over the unit square of uv, for files."""
    grid = latents.baked.grid
    if grid is None:
        parts = [x for part in latents.varying for x in part.sources]
        _check_over_uv(parts, where, "a file has texels over uv")
        grid = grid_of(parts, resolution)
    blocks = (grid.uv(i, min(i + BLOCK, grid.texels)) for i in range(0, grid.texels, BLOCK))
    return Texture.of(latents.model, np.concatenate([*map(latents.at, blocks)])), grid


def _check_over_uv(parts: Sequence["mi.Object"], where: str, reason: str) -> None:
    for part in parts:
        if dependence := not_over_uv(part):
            raise ParameterError(f"{where}: a parameter depends on {dependence}, but {reason}")


def _progress(grid: TexelGrid, where: str) -> tqdm:
    """A progress bar on stderr, in files too, of what takes longer than a moment."""
    return tqdm(
        total=grid.texels,
        desc=f"{where}: {grid.width} x {grid.height} texels are baked (a lower 'resolution' is "
        "faster)",
        unit=" texels",
        unit_scale=True,
        delay=PROGRESS_DELAY,
        mininterval=PROGRESS_DELAY,
    )
