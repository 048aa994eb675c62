"""What lies below a coat: as a material, at rows of values of its parameters, at points of uv."""

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core.table import node_pairs, table_of_values
from urushi.material.material import Material
from urushi.material.reflector import Reflector
from urushi.material.substrate import Substrate, of_material
from urushi.material.symmetry import symmetrise
from urushi.material.values import encode_source
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.axes import AxisLatents, without_faint
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.axes import BOTTOM, NANOMETRES, WAVELENGTH, Varying
from urushi.mitsuba.reading.below import below
from urushi.mitsuba.reading.bsdf import reflection_source
from urushi.mitsuba.reading.derived import derived
from urushi.mitsuba.reading.grid import not_over_uv
from urushi.mitsuba.reading.known import known_surface
from urushi.mitsuba.reading.parameters import CoatTextures, check_bottom
from urushi.mitsuba.reading.replaced import SWITCHES, replaced
from urushi.nets import lobe as lobes
from urushi.nets.lobe import with_two_widths
from urushi.nets.weights import Model
from urushi.textures.axes import FAINT

#: Width below which a lobe stays beside the table of a bottom, which is too coarse for it.
NARROW = 0.0225

#: Bottoms whose tables are computed at once: bounds memory.
BLOCK = 48

#: Points of uv at which a bottom of values is compared, and its greatest relative error there.
COMPARED, TOLERANCE = 256, 2e-3

#: Relative change of f with the wavelength up to which a bottom is grey.
GREY = 1e-4

#: [1/sr] Least rest of a nested coat.
BLACK = 1e-8

#: Index of a coat to which the numbers of a bottom's parameters are relative.
INDEX = "eta"


def nested_latents(bottom: "mi.BSDF", model: Model) -> Any:
    """The codes of a bottom that has codes of the same weights, or None."""
    nested = known_surface(bottom).latents
    same = nested is not None and nested.model.fingerprint == model.fingerprint
    return nested if same else None


def bottom_material(model: Model, bottom: "mi.BSDF", where: str) -> Material:
    """The material of a bottom that is the same everywhere, at the bands that are read."""
    nested = nested_latents(bottom, model)
    if nested is not None and nested.material is not None:
        own, count = nested.material, spectrum.channel_count()
        if own.channels != count and own.channels == spectrum.COUNT:
            bands = list(spectrum.FINE_AT_RGB)
            table = None if own.table is None else own.table[..., bands]
            own = replace(own, latents=own.latents[bands], table=table)
        return own
    check_bottom(bottom, where)
    source = reflection_source(bottom)
    material, deviations = encode_source(source, model, name=f"{where}: the nested BSDF")
    for sentence in deviations.warnings():
        mi.Log(mi.LogLevel.Warn, f"{where}: {sentence}")
    exact = known_surface(bottom).table_source() if model.widths == 1 else None
    if exact is not None:
        wi, wo = node_pairs()
        f = symmetrise(
            reflection_source(exact), wi, wo, lambda f, _: probing.check_values(f, where)
        )[0]
        lobe = material.latents[:, : model.arch.lobe]
        narrow = source.lobe is not None and bool((lobe[:, 0] < NARROW).any())
        if narrow:
            f = np.maximum(f - lobes.f(lobe, wi[:, None], wo[:, None]), 0)
        material = replace(material, table=table_of_values(f), beside_lobe=narrow)
    return material


class BottomRows:
    """A bottom at rows of values of its varying parameters."""

    def __init__(self, model: Model, bottom: "mi.BSDF", coat: CoatTextures, bsdf: "mi.BSDF"):
        """bottom: as the coat has it nested. bsdf: as it reflects below the coat."""
        self._model, self._coat, self._nested, self.bsdf = model, coat, bottom, bsdf
        self.nested = nested_latents(self.bsdf, model)
        #: The texels of its codes, if these are its nodes.
        self.grid = self.nested.baked.grid if isinstance(self.nested, AxisLatents) else None
        self._varying: list[Varying] = []
        self._switches: Mapping[str, Any] = {}
        self._material: Material | None = None

    def follow(self, varying: Sequence[Varying]) -> None:
        """Take the parameters that vary."""
        self._varying = [x for x in varying if self._is_own(x)]

    @property
    def _names(self) -> list[str]:
        return [x.axis.name for x in self._varying]

    @property
    def _is_constant(self) -> bool:
        return not self._varying and not isinstance(self.nested, AxisLatents)

    def _is_own(self, varying: Varying) -> bool:
        if varying.axis.name == INDEX:  # the index of conductors is relative to the coat's
            return self.nested is None and self.bsdf is not self._nested
        return varying.axis.name.startswith(BOTTOM)

    def is_known(self) -> bool:
        """Whether rows of values reflect as the bottom does where it has these values."""
        if isinstance(self.nested, AxisLatents) or self._is_constant:
            return True
        if any(not_over_uv(x.texture) for x in self._varying if x.texture):
            some = {x.axis.name: np.array([x.axis.least]) for x in self._varying}
            return self._at(some) is not None
        rng = np.random.default_rng(0)
        uv, (wi, wo) = rng.random((COMPARED, 2)), (x[::8] for x in self._model.networks.pairs())
        si = spectrum.points(uv)
        values = {
            x.axis.name: [mi.Float(0)]
            if x.steps
            else spectrum.at_bands(si, lambda x=x: x.read(si, True))
            for x in self._varying
        }
        dr.eval(values)
        rows = {
            name: [np.broadcast_to(x.numpy(), len(uv)) for x in channels]
            for name, channels in values.items()
        }
        f = probing.texel_values(self.bsdf, wi, wo, uv, probing.Averaging())
        for self._switches in SWITCHES:
            same = True
            for channel in range(f.shape[1]):
                own = {n: x[min(channel, len(x) - 1)] for n, x in rows.items()}
                at = self._at(own)
                if at is None:
                    return False
                found = probing.texel_values(at, wi, wo, along_u(len(uv)), probing.Averaging())
                error = np.abs(found[:, channel] - f[:, channel]).sum()
                same &= bool(error < TOLERANCE * max(f[:, channel].sum(), 1e-9))
            if same:
                return True
        return False

    def is_grey(self) -> bool:
        """Whether rows of values reflect alike in all channels, or at all wavelengths."""
        if isinstance(self.nested, AxisLatents):
            return self.nested.baked.channels == 1
        sides = [(0.0, 0.0) if x.steps else (x.axis.least, x.axis.most) for x in self._varying]
        ends = list(product(*sides))[:16]
        columns = dict(zip(self._names, np.array(ends).T, strict=True)) if self._names else {}
        bsdf = self._at(columns)
        assert bsdf is not None  # for the type checker
        uv = along_u(len(ends))
        bsdf = (
            known_surface(bsdf).table_source() or bsdf
        )  # its table may have colours that codes leave out
        f = probing.texel_values(bsdf, *self._model.networks.pairs(), uv, probing.Averaging())
        return bool(np.allclose(f, f[:, :1], rtol=GREY, atol=1e-9))

    def spectral_changes(self, count: int, values: Mapping[str, np.ndarray]) -> np.ndarray:
        """Amounts (count,) by which ln f changes in equal parts of `spectrum.ENDS`.

        values: (count + 1,) of the parameters by name, all the same, and the wavelengths.
        """
        if isinstance(self.nested, AxisLatents):
            return np.zeros(count)
        with wavelengths_of(values, count + 1):
            pairs, uv = self._model.networks.pairs(), along_u(count + 1)
            f = probing.texel_values(self._of_rows(values), *pairs, uv, probing.Averaging())[:, 0]
        logs = np.log(np.maximum(f, 1e-6))
        return np.abs(np.diff(logs, axis=0)).mean(axis=1)

    def material(self) -> Material:
        """The material of a bottom that is the same everywhere."""
        if self._material is None:
            self._material = bottom_material(self._model, self.bsdf, self._coat.where)
        return self._material

    def _at(self, rows: Mapping[str, np.ndarray]) -> "mi.BSDF | None":
        """The BSDF whose varying parameters have rows (k,) of values along u, by their names."""
        textures = {}
        for x in self._varying:
            if x.texture:
                row = _row(rows[x.axis.name])
                textures[id(x.texture)] = _shifted(x.texture, row) if x.steps else row
        coat = self._coat
        if INDEX in rows and INDEX in self._names:
            constant = any(x.axis.name == INDEX and x.steps for x in self._varying)
            coat = coat.of_index(_row(rows[INDEX] + (coat.eta if constant else 0)))
        if not textures:
            return self.bsdf if coat is self._coat else below(self._nested, coat)
        found = replaced(self._nested, lambda x: textures.get(id(x), x), switches=self._switches)
        return None if found is None else below(found, coat)

    def codes(self, values: Mapping[str, np.ndarray], channels: int) -> np.ndarray:
        """Codes (C, k, L) of rows (k,) of values, C one or `channels`."""
        count = len(next(iter(values.values())))
        if isinstance(self.nested, AxisLatents):
            return without_faint(self._model, self.nested.codes(_inside(values)))
        if self._is_constant and not mi.is_spectral:
            codes = self.material().latents[:channels]
            return np.repeat(codes[:, None], count, axis=1)
        rows, which = self._distinct(values)
        bsdf, uv = self._of_rows(rows), along_u(len(next(iter(rows.values()))))
        with wavelengths_of(rows, len(uv)):
            codes = probed_codes(self._model, bsdf, uv, self._coat.where)
        return np.moveaxis(codes[:, :channels], 1, 0)[:, which]

    def substrate(
        self, values: Mapping[str, np.ndarray], channels: int
    ) -> tuple[Substrate, np.ndarray]:
        """The bottoms of rows (k,) of values, and the place (channels, k) of each among them."""
        count = len(next(iter(values.values())))
        if self._is_constant and not mi.is_spectral:
            whole = of_material(self.material())
            places = np.repeat(np.arange(channels)[:, None], count, axis=1)
            return whole, places % whole.channels
        if isinstance(self.nested, AxisLatents):
            codes = self.nested.codes(_inside(values))
            places = np.arange(codes[..., 0].size).reshape(codes.shape[:2])
            flat = codes.reshape(-1, codes.shape[-1])
            logs = self._model.networks.table(flat)
            assert logs is not None  # a rest has at least `FAINT`
            logs = np.log(np.maximum(np.exp(logs) - FAINT, BLACK))
            below = Substrate.of(Reflector.of_logs(logs, flat[:, : self._model.arch.lobe]))
            return below, np.broadcast_to(places, (channels, count))
        rows, which = self._distinct(values)
        different, parts = len(next(iter(rows.values()))), []
        for start in range(0, different, BLOCK):
            some = {name: x[start : start + BLOCK] for name, x in rows.items()}
            with wavelengths_of(some, len(next(iter(some.values())))):
                parts.append(self._part(some, channels))
        tables, tops = ([*side] for side in zip(*parts, strict=True))
        top = None if tops[0] is None else np.concatenate(tops, axis=1)
        places = np.arange(channels)[:, None] * different + which
        if top is not None:
            top = top.reshape(-1, top.shape[-1])
        if tables[0] is None:
            assert top is not None  # for the type checker
            rest = np.tile(self._model.networks.empty_rest(), (len(top), 1))
            codes = np.concatenate([top, rest], axis=1, dtype=np.float32)
            return Substrate.of(Reflector.of(Material(codes, self._model))), places
        table = np.concatenate(tables, axis=-1)
        return Substrate.of(Reflector.of_logs(table.reshape(*table.shape[:3], -1), top)), places

    def _distinct(
        self, values: Mapping[str, np.ndarray]
    ) -> tuple[dict[str, np.ndarray], np.ndarray]:
        """Different rows, and the place (k,) of each row among them."""
        names = [*self._names, *([NANOMETRES] if mi.is_spectral else [])]
        default = np.full(len(next(iter(values.values()))), spectrum.RGB[1])
        own = np.stack([values.get(name, default) for name in names or [NANOMETRES]])
        different, which = np.unique(own, axis=1, return_inverse=True)
        return dict(zip(names or [NANOMETRES], different, strict=True)), which.ravel()

    def _of_rows(self, rows: Mapping[str, np.ndarray]) -> "mi.BSDF":
        found = self._at(rows)
        assert found is not None  # `is_known`
        return found

    def _part(
        self, rows: Mapping[str, np.ndarray], channels: int
    ) -> tuple[np.ndarray | None, np.ndarray | None]:
        """Tables (U, V, W, channels, k), and lobes (channels, k, N) beside them.

        No table: they are their lobes; no lobes: they are their tables.
        """
        bsdf, uv = self._of_rows(rows), along_u(len(next(iter(rows.values()))))
        known = known_lobes(self._model, bsdf, uv, self._coat.where)
        bare = known is not None and known_surface(bsdf).lobe_only
        if known is not None:
            known = np.moveaxis(known[:, :channels], 1, 0)
            if bare:
                known[..., :4] = np.minimum(known[..., :4], 1)
                return None, known
        exact = known_surface(bsdf).table_source() or bsdf
        wi, wo = (w.reshape(-1, 3) for w in node_pairs())
        pairs, where = self._model.networks.pairs(), self._coat.where
        average = probing.needed_averaging(exact, *pairs, uv, where)
        f = probing.texel_values(exact, wi, wo, uv, average)[:, :channels]
        values = np.moveaxis(probing.check_values(f, self._coat.where), 1, 0)
        if known is not None:
            values = np.maximum(values - lobes.f(known[..., None, :], wi, wo), 0)
        table = table_of_values(values.reshape(-1, len(wi)).T)
        return table.reshape(*table.shape[:3], channels, -1), known


def _inside(values: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Values by the names that parameters have in a nested coat."""
    own = [name for name in values if name.startswith(BOTTOM) or name == WAVELENGTH]
    return {name.removeprefix(BOTTOM): values[name] for name in own}


def along_u(count: int) -> np.ndarray:
    """Points uv (count, 2) in the middles of a row of texels."""
    return np.stack([(np.arange(count) + 0.5) / count, np.full(count, 0.5)], axis=-1)


def _row(values: np.ndarray) -> "mi.Texture":
    """A texture of values along u."""
    data = mi.Bitmap(np.array(values, np.float32).reshape(1, -1, 1))
    options = {"raw": True, "filter_type": "nearest", "wrap_mode": "clamp"}
    return mi.load_dict({"type": "bitmap", "bitmap": data, **options})


def _shifted(texture: "mi.Texture", row: "mi.Texture") -> "mi.Texture":
    """A texture to which another is added."""
    parts = {"value": texture, "change": row}
    return derived(lambda si, active, value, change: value + change, parts)


def wavelengths_of(rows: Mapping[str, np.ndarray], count: int) -> Any:
    """The context in which rows (count,) along u are read at their wavelengths."""
    if not mi.is_spectral:
        return contextlib.nullcontext()
    own = rows.get(NANOMETRES, np.full(count, spectrum.RGB[1]))
    return spectrum.reading_at(own.astype(np.float32))


def probed_codes(model: Model, bottom: "mi.BSDF", uv: np.ndarray, where: str) -> np.ndarray:
    """Codes (M, C, L) of a bottom at points uv (M, 2)."""
    nested = nested_latents(bottom, model)
    if nested is not None:
        return nested.at(uv)
    lobe = known_lobes(model, bottom, uv, where)
    if lobe is not None and known_surface(bottom).lobe_only:
        for reach in (lobe[..., :4], lobe[..., 6:]):  # all but the index
            np.minimum(reach, 1, out=reach)
        rest = np.broadcast_to(model.networks.empty_rest(), (*lobe.shape[:2], model.arch.rest))
        return np.concatenate([lobe, rest], axis=-1)
    pairs = model.networks.pairs()
    average = probing.needed_averaging(bottom, *pairs, uv, where, model.widths)
    f = probing.check_values(probing.texel_values(bottom, *pairs, uv, average), where)
    # Each row is a material of its own.
    return model.networks.encode(f[:, :, None], None if lobe is None else lobe[:, :, None])[:, :, 0]


def known_lobes(model: Model, bottom: "mi.BSDF", uv: np.ndarray, where: str) -> np.ndarray | None:
    """Lobes (M, C, N) at points uv (M, 2) as codes have them; None: they are fitted."""
    found = probing.known_lobes(bottom, uv)
    if found is None:
        return None
    found = probing.check_values(found, where)
    if found.shape[-1] < model.arch.lobe:
        found = with_two_widths(found)
    # Codes of one width fit a lobe of two.
    return found if found.shape[-1] == model.arch.lobe else None
