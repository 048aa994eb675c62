"""What lies below a coat: as a material, and at points of uv."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import mitsuba as mi
import numpy as np

from urushi.core.table import node_pairs, table_of_values
from urushi.material.material import Material
from urushi.material.symmetry import symmetrise
from urushi.material.values import codes_of_values, encode_source, required_pairs
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.bsdf import reflection_source
from urushi.mitsuba.reading.known import known_surface
from urushi.mitsuba.reading.nested import check_bottom
from urushi.mitsuba.reading.parameters import CoatTextures
from urushi.nets.lobe import with_two_widths
from urushi.nets.transmittance import remainder, table_beside
from urushi.nets.weights import Model


@dataclass(frozen=True)
class Layer:
    """A coat over a bottom, as a scene describes them."""

    coat: CoatTextures
    nested: Any  # the bottom, a BSDF of Mitsuba's, as the coat has it nested
    below: Any  # the same as it reflects below the coat, see `reading.changed`

    @property
    def relative(self) -> bool:
        """Whether the bottom reflects otherwise below the coat than in air."""
        return self.below is not self.nested

    @cached_property
    def numbers(self) -> dict[str, np.ndarray]:
        """The coat in the middle of uv, see `CoatTextures.numbers`; in all bands of constants."""
        with spectrum.reading_at(spectrum.FINE):
            return self.coat.numbers(spectrum.MIDDLE)


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
    name = f"{where}: the nested BSDF"
    material, deviations = encode_source(source, model, name=name)
    for sentence in deviations.warnings():
        mi.Log(mi.LogLevel.Warn, f"{where}: {sentence}")
    if model.widths == 1 and source.lobe is not None and not source.bare:
        opened = reflection_source(known_surface(bottom).table_source() or bottom)
        checked = opened._replace(f=lambda wi, wo: probing.check_values(opened.f(wi, wo), where))
        lobe = material.latents[:, : model.arch.lobe]
        table = table_beside(symmetrise(checked, *node_pairs())[0], lobe)
        material = replace(material, table=table, beside_lobe=True)
    return material


def probed_codes(
    model: Model, bottom: "mi.BSDF", uv: np.ndarray, where: str, bounded: bool = False
) -> np.ndarray:
    """Codes (M, C, L) of a bottom at points uv (M, 2).

    bounded: whether they have the bottom's albedo, which takes several times as many evaluations.
    """
    nested = nested_latents(bottom, model)
    if nested is not None:
        return nested.at(uv)
    lobe = known_lobes(model, bottom, uv, where)
    if lobe is not None and known_surface(bottom).lobe_only:
        for reach in (lobe[..., :4], lobe[..., 6:]):  # all but the index
            np.minimum(reach, 1, out=reach)
        rest = np.broadcast_to(model.networks.empty_rest(), (*lobe.shape[:2], model.arch.rest))
        return np.concatenate([lobe, rest], axis=-1)
    probes = model.networks.pairs()
    average = probing.needed_averaging(bottom, *probes, uv, where, model.widths)
    pairs = required_pairs(None, model, table=False) if bounded else probes
    f = probing.check_values(probing.texel_values(bottom, *pairs, uv, average), where)[:, :, None]
    lobe = None if lobe is None else lobe[:, :, None]  # each row is a material of its own
    codes = codes_of_values(f, model, lobe) if bounded else model.networks.encode(f, lobe)
    return codes[:, :, 0]


def probed_tables(
    model: Model, bottom: "mi.BSDF", uv: np.ndarray, where: str, channels: int
) -> tuple[np.ndarray, np.ndarray | None]:
    """ln g (channels, M, U, V, W) at points uv (M, 2), beside lobes (channels, M, N) or None."""
    exact = known_surface(bottom).table_source() or bottom
    known = known_lobes(model, bottom, uv, where)
    wi, wo = (w.reshape(-1, 3) for w in node_pairs())
    average = probing.needed_averaging(exact, *model.networks.pairs(), uv, where)
    f = probing.texel_values(exact, wi, wo, uv, average)[:, :channels]
    f = np.moveaxis(probing.check_values(f, where), 1, 0)
    if known is not None:
        known = np.moveaxis(known[:, :channels], 1, 0)
        f = remainder(f, known[..., None, :], wi, wo)
    logs = np.moveaxis(table_of_values(f.reshape(-1, len(wi)).T), -1, 0)
    return logs.reshape(*f.shape[:2], *logs.shape[1:]), known


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
