"""Laws of random materials in closed form, one for each texel of textures; bases by their formulas.

Every parameter is drawn over its range, one value in four at an end of it.
"""

from dataclasses import dataclass, field

import mitsuba as mi
import numpy as np
import pytest
from tests.mitsuba.probes import evaluated, interaction, strip
from tests.openpbr_surface.probes import WHITE, toward
from tests.openpbr_surface.probes import loaded as openpbr
from tests.oracles import openpbr_base

from urushi.openpbr_surface.parameters import PARAMETERS, names_of

pytestmark = pytest.mark.usefixtures("rgb")

#: Materials of a kind.
TEXELS = 24

#: Beginnings of the names of the base's parameters.
BASE = ("base", "specular")

COLOR = ((0, 1),) * 3
ROUGH = {"specular_roughness": (0, 1)}
TWO_WIDTHS = {**ROUGH, "specular_roughness_anisotropy": (0, 0.95)}
COLORS = {"base_color": COLOR, "specular_color": COLOR, "base_metalness": (0, 1)}
FILM = {"thin_film_thickness": (0, 1.5), "thin_film_ior": (1.1, 2.4), "thin_film_weight": (0, 1)}
GLASS = {"transmission_weight": 1.0, "interior": True}
SHARES = {"transmission_weight": (0, 1), "subsurface_weight": (0, 1), "base_metalness": (0, 1)}


@dataclass
class Kind:
    """Random materials."""

    ranges: dict  # by parameter: of a number, or of the channels
    constants: dict = field(default_factory=dict)
    furnace: float = 0.006  # largest distance of a white one's albedo from one
    across: float | None = None  # index below relative to above; None: it is opaque

    @property
    def mode(self) -> str:
        """The transport whose f are shares of power: of radiance, they change across an index."""
        return "Radiance" if self.across is None else "Importance"


KINDS = {
    "base": Kind(COLORS | ROUGH | {"specular_ior": (1, 3), "base_weight": (0, 1)}),
    "weighted": Kind(ROUGH | {"base_color": COLOR, "specular_weight": (0, 2)}),
    "low index": Kind(COLORS | ROUGH | {"specular_ior": (0.4, 1)}, furnace=0.012),
    "two widths": Kind(COLORS | TWO_WIDTHS | {"specular_ior": (1, 3)}, furnace=0.012),
    "rough slab": Kind(
        COLORS | ROUGH | {"specular_ior": (0.6, 2.5), "base_diffuse_roughness": (0, 1)}
    ),
    "film": Kind(COLORS | ROUGH | FILM | {"thin_film_ior": (0.5, 2.4)}, furnace=0.02),
    "fuzz": Kind(COLORS | ROUGH | {"fuzz_weight": (0, 1), "fuzz_roughness": (0.1, 1)}),
    "glass": Kind(TWO_WIDTHS | {"specular_color": COLOR}, GLASS, furnace=0.015, across=1.5),
    "filmed glass": Kind(ROUGH | FILM, GLASS, across=1.5),
    "air below": Kind(ROUGH, GLASS | {"specular_ior": 0.8}, across=0.8),
    "mixture": Kind(ROUGH | SHARES | COLORS, {"interior": True}, across=1.5),
    "leaf": Kind(
        ROUGH
        | SHARES
        | {"subsurface_color": COLOR, "subsurface_scatter_anisotropy": (-1, 1)}
        | {"base_diffuse_roughness": (0, 1)},
        {"geometry_thin_walled": True, "transmission_weight": 0.0},
        across=1.0,
    ),
}


def values(kind, seed=7):
    """Random values of each parameter, (TEXELS, channels)."""
    rng, found = np.random.default_rng(seed), {}
    for name, ranges in kind.ranges.items():
        low, high = np.atleast_2d(ranges).T
        x = rng.random((TEXELS, len(low)))
        ends = rng.random(x.shape) < 0.25
        found[name] = low + (high - low) * np.where(ends, np.round(x), x)
    return found


def loaded(kind, **replaced):
    """All materials of a kind as one; replaced: parameters of all."""
    given = {name: strip(*x, filter_type="nearest") for name, x in values(kind).items()}
    return openpbr(**given | kind.constants | replaced)


def uv(texel):
    """The middle (N, 2) of texels (N,)."""
    return np.column_stack([(texel + 0.5) / TEXELS, np.full(len(texel), 0.5)])


def shares(bsdf, wi, mode, count=1 << 14):
    """Mean weights (TEXELS,) of the first channel for light from wi, and standard errors.

    Each weight is f cos over the density at the drawn direction.
    """
    texel = np.repeat(np.arange(TEXELS), count)
    u = np.random.default_rng(2).random((3, len(texel)), np.float32)
    context = mi.BSDFContext(getattr(mi.TransportMode, mode))
    si = interaction(np.repeat(wi, count, 0), uv(texel))
    sample, weight = bsdf.sample(context, si, mi.Float(u[0]), mi.Point2f(u[1:]))
    f_cos, density = bsdf.eval_pdf(context, si, sample.wo)
    drawn, weight = sample.pdf.numpy() > 0, weight[0].numpy()
    expected = f_cos[0].numpy()[drawn] / density.numpy()[drawn]
    assert (np.abs(weight[drawn] - expected) < 0.02 * expected + 1e-4).mean() > 0.999  # last digits
    weight = np.float64(weight).reshape(TEXELS, -1)
    return weight.mean(-1), weight.std(-1) / count**0.5


def pairs(kind, count, seed=1):
    """Directions (count, 3) on all sides that light comes from or goes to; half near the mirror."""
    w = np.random.default_rng(seed).normal(size=(2, count, 3))
    w[1, ::2] = w[0, ::2] * [-1, -1, 1] + 0.2 * w[1, ::2]
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    w[..., 2] += 0.06 * np.sign(w[..., 2])  # away from the horizon
    if kind.across is None:
        w[..., 2] = np.abs(w[..., 2])
    return w / np.linalg.norm(w, axis=-1, keepdims=True)


@pytest.mark.parametrize("name", KINDS)
def test_white_materials_reflect_all_light(name):
    """From either side, within the tables of interfaces and four standard errors of samples."""
    kind = KINDS[name]
    colors = [x for x in kind.ranges if x.endswith("color")]
    white = dict.fromkeys((*colors, "base_color"), WHITE)
    bsdf, turns = loaded(kind, **white, base_weight=1.0), np.degrees(2.4 * np.arange(TEXELS))
    for cosine in (1.0, 0.6, 0.2, *(() if kind.across is None else (-0.9, -0.4))):
        found, error = shares(bsdf, toward(cosine, turns), kind.mode)
        assert (np.abs(found - 1) < kind.furnace + 4 * error).all()


@pytest.mark.parametrize("name", [x for x in KINDS if x != "fuzz"])
def test_light_paths_may_be_reversed(name):
    """f of radiance times the square of the index on wo's side, up to rounding; f is positive.

    Importance has the square of the relative index less, in transmitted light.
    """
    kind, texel = KINDS[name], np.repeat(np.arange(TEXELS), 40)
    bsdf, (wi, wo) = loaded(kind), pairs(kind, len(texel))
    squares = [np.where(w[:, 2:] > 0, 1, (kind.across or 1) ** 2) for w in (wi, wo)]
    f = evaluated(bsdf, wi, wo, uv(texel))[0]
    assert f.min() >= 0 and np.isfinite(f).all()
    back = evaluated(bsdf, wo, wi, uv(texel))[0] * squares[0]
    np.testing.assert_allclose(f * squares[1], back, rtol=2e-3, atol=2e-5)
    light = evaluated(bsdf, wi, wo, uv(texel), "Importance")[0]
    np.testing.assert_allclose(light * squares[0], f * squares[1], rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize("name", ["base", "weighted", "low index", "two widths"])
def test_a_base_is_its_formula(name):
    """Eight materials, within the tables of the interface: E of each, and single pairs."""
    kind, count, number = KINDS[name], 5, 8
    texel = np.repeat(np.arange(number), count)
    wi, wo = pairs(kind, len(texel))
    f = evaluated(loaded(kind), wi, wo, uv(texel))[0].reshape(number, count, 3)
    defaults = {x: np.atleast_1d(PARAMETERS[x].default) for x in names_of(*BASE)}
    drawn, weight = values(kind), (wi[:, 2] * wo[:, 2]).reshape(number, count, 1)
    for k in range(number):
        at = slice(k * count, (k + 1) * count)
        own = defaults | {n: x[k] for n, x in drawn.items()}
        expected = openpbr_base.base(own, wi[at], wo[at])
        off = np.abs(f[k] - expected)
        assert (off * weight[k]).sum() < 0.005 * (expected * weight[k]).sum() + 1e-5
        assert (off < 0.02 * expected + 0.005).all()
