"""Codes of a coat over a Mitsuba BSDF: constant, or over axes.

Parameters that vary or carry gradients are axes. A bottom of an unknown kind that varies has the
axes u and v, with a node for each texel. An update bakes again what has changed.
"""

from collections.abc import Sequence

import drjit as dr
import mitsuba as mi
import numpy as np
from tqdm import tqdm

from urushi import checks
from urushi.checks import MIN_INDEX_STEP, CoatParameters
from urushi.errors import ParameterError
from urushi.material.layer import layer_material
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.axes import AxisLatents, Varying
from urushi.mitsuba.latents.codes import ConstantLatents
from urushi.mitsuba.latents.texels import texel_axes
from urushi.mitsuba.reading.axes import (
    WAVELENGTH,
    check_coat,
    varying_parameters,
)
from urushi.mitsuba.reading.bottoms import Layer, bottom_material, nested_latents, probed_codes
from urushi.mitsuba.reading.coated_rows import CoatedRows
from urushi.mitsuba.reading.grid import check_nodes, not_over_uv, varying_textures
from urushi.mitsuba.reading.joined import agree, joined
from urushi.mitsuba.reading.rows import rows_of
from urushi.mitsuba.snapshot import has_gradients, writable
from urushi.nets.weights import Model
from urushi.textures.axes import AXES, Axis, Baked, bake
from urushi.textures.layering import layer_rows
from urushi.textures.store import ONE_TEXEL, TexelGrid, Texture

#: Texels per side of what is no bitmap, the least and the largest side that is chosen, and texels
#: that are read at once.
PROCEDURAL, LEAST, LARGEST, BLOCK = 256, 64, 512, 1 << 13

#: Seconds before progress is shown, and between two reports.
PROGRESS_DELAY = 3.0

Latents = ConstantLatents | AxisLatents


class Baker:
    """The codes of a coat over a bottom; `update` computes them, and again after a change."""

    def __init__(self, model: Model, resolution: int):
        """resolution: texels per side, 0 to choose."""
        self.model, self._resolution = model, resolution
        self._last: AxisLatents | None = None
        self._fixed: list[np.ndarray] = []  # numbers on which the last one depends
        self._led: list[Varying] = []  # its parameters that follow others
        self.absorbs = False  # whether the coat has no interface and does not scatter, anywhere

    def update(self, layer: Layer) -> Latents:
        """The codes for the current parameters of the layer, which is always the same.

        Raises:
            ParameterError: a parameter is refused, or carries gradients that its codes have not.
        """
        for part in (layer.nested, *layer.coat.textures.values()):
            check_nodes(part, layer.coat.where)
        check_coat(layer.coat)
        codes = nested_latents(layer.below, self.model)
        nested = codes if isinstance(codes, AxisLatents) else None
        texels = None if nested is None else nested.baked.grid  # of its codes
        known = None if nested is None else [] if texels else nested.varying
        varying = joined(varying_parameters(layer.coat, layer.nested, known))
        names = {x.axis.name for x in varying}
        with dr.suspend_grad():
            eta, albedo = (layer.numbers[name] for name in ("eta", "albedo"))
            clear = bool((np.abs(eta - 1) < MIN_INDEX_STEP).all()) and not albedo.any()
            self.absorbs = clear and not names & {"eta", "albedo"}
            found: Latents | None = None
            if varying and not (texels or layer.coat.coloured):
                found = self._over_parameters(layer, varying, nested)
            attached = any(x.differentiable for x in varying) or has_gradients(layer.nested)
            held = self.absorbs or (isinstance(found, AxisLatents) and found.differentiable)
            if attached and not held:
                raise ParameterError(
                    f"{layer.coat.where}: a parameter carries gradients, which codes over the "
                    f"nested '{layer.nested.class_name()}' do not have; disable them, or nest a "
                    "BSDF whose parameters are known, with at most six that vary"
                )
            if found is not None:
                return found
            if not (varying or texels):
                return self._constant(layer)
            return self._over_texels(layer, texels or ONE_TEXEL)

    def _constant(self, layer: Layer) -> ConstantLatents:
        with spectrum.reading_at(spectrum.FINE):
            coat = layer.coat.layering(spectrum.MIDDLE)
            bottom = bottom_material(self.model, layer.below, layer.coat.where)
            columns = [column[0] for column in coat.columns()]
            return ConstantLatents(layer_material(CoatParameters.of_columns(columns), bottom))

    def _over_parameters(
        self, layer: Layer, varying: list[Varying], nested: AxisLatents | None
    ) -> AxisLatents | None:
        """The codes along the parameters that vary; None: the bottom is unknown, or too many
        vary.

        nested: codes of the bottom, if these vary along axes.
        """
        constants, led = [x for x in varying if x.changes], [x for x in varying if x.leader]
        varying = [x for x in varying if not (x.changes or x.leader)]
        if len(varying) > AXES:
            return None
        axes, fixed = [x.axis for x in varying], _numbers(layer, [*varying, *led], nested)
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
        rows = rows_of(self.model, layer, [*varying, *led, *constants])
        if rows is None:
            return None
        coated = CoatedRows(self.model, layer, rows, varying, led, constants)
        if coated.needs_wavelengths:
            varying = [*varying, coated.with_wavelengths()]
            if len(varying) > AXES:
                return None
        changes = {x.axis.name: x.changes for x in constants if x.changes is not None}
        baked = bake(self.model, [x.axis for x in varying], coated, changes)
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

    def _over_texels(self, layer: Layer, least: TexelGrid) -> AxisLatents:
        """The codes at texels over the unit square of uv, which repeats.

        least: there are at least as many texels.
        """
        coat, bottom = layer.coat, layer.below
        parts = [*coat.textures.values(), bottom]
        _check_over_uv(
            parts,
            coat.where,
            f"the nested '{bottom.class_name()}' is evaluated over uv; give textures over uv, or "
            "use the plugin 'layered', which evaluates every point",
        )
        grid = grid_of(parts, self._resolution, least)
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


def _numbers(
    layer: Layer, varying: Sequence[Varying], nested: AxisLatents | None
) -> list[np.ndarray]:
    """What codes along the axes depend on beside them."""
    names = {x.axis.name for x in varying}
    numbers = [x for name, x in layer.numbers.items() if name not in names]
    if nested is not None:
        return [*numbers, np.array([id(nested.baked)])]
    left_out = {id(x.texture) for x in varying}
    parameters = mi.traverse(layer.nested)
    for key, value in writable(layer.nested):
        owner = parameters.properties[key][2]
        if id(owner) not in left_out:
            numbers.append(np.array(getattr(value, "matrix", value)))
    return numbers


def grid_of(
    parts: Sequence["mi.Object"], resolution: int, least: TexelGrid = ONE_TEXEL
) -> TexelGrid:
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
