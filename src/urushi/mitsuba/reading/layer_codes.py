"""Codes of a coat over a Mitsuba BSDF: constant, or over axes.

Parameters that vary or carry gradients are axes. A bottom of an unknown kind that varies has the
axes u and v, with a node for each texel. An update bakes again what has changed.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np
from tqdm import tqdm

from urushi import checks
from urushi.checks import MIN_INDEX_STEP, CoatParameters
from urushi.errors import ParameterError
from urushi.material.layer import layer_material
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.codes import ConstantLatents
from urushi.mitsuba.latents.over_axes import AxisLatents, texel_axes
from urushi.mitsuba.reading.bottoms import Layer, bottom_material, nested_latents, probed_codes
from urushi.mitsuba.reading.coated_rows import CoatedRows
from urushi.mitsuba.reading.grid import check_nodes, not_over_uv, varying_textures
from urushi.mitsuba.reading.ranges import check_coat
from urushi.mitsuba.reading.rows import rows_of
from urushi.mitsuba.reading.varying import agree, joined, varying_parameters
from urushi.mitsuba.snapshot import has_gradients, writable
from urushi.nets.weights import Model
from urushi.textures.axes import Varying
from urushi.textures.baking import Baked, bake
from urushi.textures.layering import layer_rows
from urushi.textures.packing import Texture
from urushi.textures.point_codes import AXES
from urushi.textures.store import ONE_TEXEL, TexelGrid

#: Texels per side of what is no bitmap, the least and the largest side that is chosen, and texels
#: that are read at once.
PROCEDURAL, LEAST, LARGEST, BLOCK = 256, 64, 512, 1 << 13

#: Seconds before progress is shown, and between two reports.
PROGRESS_DELAY = 3.0

Latents = ConstantLatents | AxisLatents


class Described(NamedTuple):
    """The parameters of a layer that vary, and the numbers of all others."""

    varying: list[Varying]
    led: list[Varying]  # those that follow others
    constants: list[Varying]  # those that carry gradients
    numbers: list[np.ndarray]

    @classmethod
    def of(
        cls, layer: Layer, parameters: Sequence[Varying], nested: AxisLatents | None
    ) -> "Described":
        """nested: codes of the bottom, if these vary along axes."""
        varying = [x for x in parameters if not (x.changes or x.leader)]
        led = [x for x in parameters if x.leader]
        names = {x.axis.name for x in (*varying, *led)}
        numbers = [x for name, x in layer.numbers.items() if name not in names]
        if nested is not None:
            numbers.append(np.array([id(nested.baked)]))
        else:
            left_out, listed = {id(x.texture) for x in (*varying, *led)}, mi.traverse(layer.nested)
            for key, value in writable(layer.nested):
                if id(listed.properties[key][2]) not in left_out:
                    numbers.append(np.array(getattr(value, "matrix", value)))
        return cls(varying, led, [x for x in parameters if x.changes], numbers)

    def lies_within(self, other: "Described") -> bool:
        """Whether codes along the axes of another layer are codes of this one."""
        return (
            [x.axis.name for x in self.varying] == [x.axis.name for x in other.varying]
            and [x.axis.name for x in self.constants] == [x.axis.name for x in other.constants]
            and len(self.led) == len(other.led)
            and len(self.numbers) == len(other.numbers)
            and all(
                a.axis.contains(b.axis) for a, b in zip(other.varying, self.varying, strict=True)
            )
            and all(map(agree, other.led, self.led))
            and all(map(np.array_equal, self.numbers, other.numbers))
        )


class Baker:
    """The codes of a coat over a bottom; `update` computes them, and again after a change."""

    def __init__(self, model: Model, resolution: int):
        """resolution: texels per side, 0 to choose."""
        self.model, self._resolution = model, resolution
        self._last: tuple[Described, AxisLatents] | None = None  # as baked, and the last codes
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
        relative = codes is None and layer.relative
        varying = joined(varying_parameters(layer.coat, layer.nested, known, relative))
        names = {x.axis.name for x in varying}
        with dr.suspend_grad():
            eta, albedo = (layer.numbers[name] for name in ("eta", "albedo"))
            clear = bool((np.abs(eta - 1) < MIN_INDEX_STEP).all()) and not albedo.any()
            self.absorbs = clear and not names & {"eta", "albedo"}
            found: Latents | None = None
            if varying and not (texels or layer.coat.coloured):
                found = self._over_parameters(layer, Described.of(layer, varying, nested))
            attached = any(x.differentiable for x in varying) or has_gradients(layer.nested)
            held = self.absorbs or (
                isinstance(found, AxisLatents) and any(x.differentiable for x in found.varying)
            )
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

    def _over_parameters(self, layer: Layer, described: Described) -> AxisLatents | None:
        """The codes along the parameters that vary; None: the bottom is unknown, or too many
        vary."""
        varying, led, constants, _ = described
        if len(varying) > AXES:
            return None
        if self._last is not None and described.lies_within(self._last[0]):
            as_baked, latents = self._last
            along = [
                x._replace(axis=axis) for x, axis in zip(varying, latents.baked.axes, strict=False)
            ]
            # The wavelength may follow, whose place on its axis is as before.
            along += latents.varying[len(varying) : len(latents.baked.axes)]
            now = [*along, *constants]
            if [*map(_gradient_of, now)] != [*map(_gradient_of, latents.varying)]:
                latents = AxisLatents(latents.baked, now)
                self._last = as_baked, latents
            return latents
        bottoms = rows_of(self.model, layer, [*varying, *led, *constants])
        if bottoms is None:
            return None
        rows = CoatedRows(self.model, layer, bottoms, varying, led, constants)
        if len(rows.varying) > AXES:
            return None
        changes = {x.axis.name: x.changes for x in constants if x.changes is not None}
        axes = [x.axis for x in rows.varying]
        baked = bake(self.model, axes, rows, changes)
        latents = AxisLatents(baked, [*rows.varying, *constants])
        self._last = described, latents
        return latents

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
        for uv in _blocks(grid, coat.where):
            z = probed_codes(self.model, bottom, uv, coat.where)
            own = coat.layering(uv)
            left |= checks.outside_training(own)
            columns = [np.broadcast_to(x, z.shape[:2])[..., None] for x in own.columns()]
            texels.append(np.concatenate([z, *columns], axis=-1, dtype=np.float32))
        checks.warn_of_training(left, f"{coat.where}:")
        whole = np.concatenate(texels)
        flat = whole.reshape(-1, whole.shape[-1])
        different, index = np.unique(flat, axis=0, return_inverse=True)
        codes = layer_rows(self.model, different)[index.reshape(whole.shape[:2])]
        return AxisLatents(Baked.of_texels(self.model, codes, grid), texel_axes(grid))


def _gradient_of(parameter: Varying) -> tuple["mi.Texture | None", bool]:
    """The texture of a bottom's parameter, and whether the parameter carries a gradient."""
    return parameter.texture, parameter.differentiable


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
    codes = np.concatenate([*latents.at_all(_blocks(grid, where))])
    return Texture.of(latents.model, codes), grid


def _check_over_uv(parts: Sequence["mi.Object"], where: str, reason: str) -> None:
    for part in parts:
        if dependence := not_over_uv(part):
            raise ParameterError(f"{where}: a parameter depends on {dependence}, but {reason}")


def _blocks(grid: TexelGrid, where: str) -> Iterator[np.ndarray]:
    """The uv of texels, many at once; what takes longer than a moment has a progress bar on stderr,
    in files too."""
    with tqdm(
        total=grid.texels,
        desc=f"{where}: {grid.width} x {grid.height} texels are baked (a lower 'resolution' is "
        "faster)",
        unit=" texels",
        unit_scale=True,
        delay=PROGRESS_DELAY,
        mininterval=PROGRESS_DELAY,
    ) as bar:
        for start in range(0, grid.texels, BLOCK):
            uv = grid.uv(start, start + BLOCK)
            yield uv
            bar.update(len(uv))
