"""No code reflects too much light, by a finer quadrature and also between the rule's angles."""

from dataclasses import replace

import numpy as np
import pytest
from tests.directions import at_cosines
from tests.material.conftest import with_gain

import urushi
from urushi.checks import CoatParameters
from urushi.core import quadrature
from urushi.core.direction_sets import cosine_pairs
from urushi.material import Material, encode, energy, layer
from urushi.material.albedo_rule import albedo_rule
from urushi.material.energy import code_albedos
from urushi.material.layer import layer_material
from urushi.material.values import codes_of_values, evaluate_source, required_pairs
from urushi.nets import lobe as lobes
from urushi.nets.weights import anisotropic_model, default_model
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS

#: None of the rule's angles is among these.
COSINES = np.array([0.99, 0.88, 0.68, 0.45, 0.27, 0.15, 0.06, 0.025])
WI = at_cosines(COSINES)

#: Excess of the albedo of shipped codes between the rule's angles.
BETWEEN = 0.004


FRESNEL = {
    "white": (1, 1, 0, 1.5, 0),
    "schlick": (0.3, 1, 0, 1.5, 0),
    "glass": (0, 0, 1, 1.5, 0),
    "gold": (0, 0, 1, 0.2, 3.9),
}


@pytest.mark.parametrize(
    "alpha",
    [(0.01,), (0.017,), (0.03,), (0.11,), (0.47,), (1.0,), (0.05, 0.4), (0.4, 0.05), (0.02, 0.02)],
)
def test_albedos_of_lobes_agree_with_both_quadratures(alpha, monkeypatch):
    """The rule of two widths as well, between whose axes narrow lobes lie askew."""
    widths = len(alpha)
    lobe = np.array([(alpha[0], *fresnel, *alpha[1:]) for fresnel in FRESNEL.values()])
    found, rule = energy.lobe_albedos(lobe), albedo_rule(widths)
    assert found.max() < 1.004
    smooth = lobes.reflectance(lobe[:, None], rule.directions[:, 2])
    assert (found < smooth + energy.ROUGH_GAIN).all()
    by_rule = rule.albedo(lobes.f(lobe[:, None], rule.wi, rule.wo))
    np.testing.assert_allclose(found, by_rule, atol=6e-3)
    monkeypatch.setattr(quadrature, "POLAR_NODES", 128)
    monkeypatch.setattr(quadrature, "AZIMUTH_NODES", 64)
    wo, weights = quadrature.half_vector_rule(rule.directions, anisotropic=widths == 2)
    weights = weights * wo[..., 2]
    expected = [(lobes.f(own, rule.directions[:, None], wo) * weights).sum(axis=1) for own in lobe]
    np.testing.assert_allclose(found, expected, atol=4e-3)
    if widths == 1:
        np.testing.assert_allclose(by_rule, expected, atol=2.5e-3)


@pytest.mark.parametrize("bottom", [urushi.conductor(0.05, 1.0), urushi.diffuse(1.0)])
def test_lossless_stacks_reflect_at_most_everything(bottom, trained):
    material = encode(bottom, trained)
    assert material.directional_albedo(WI).max() < 1 + BETWEEN
    for alpha, eta, sigma_t, g in ((0.02, 1.3, 0, 0), (0.1, 1.5, 2, 0.5), (0.4, 1.8, 6, 0)):
        top = urushi.dielectric(alpha, eta)
        material = layer(top, material, albedo=1, sigma_t=sigma_t, g=g)
        assert material.directional_albedo(WI).max() < 1 + BETWEEN


def test_a_gaining_code_is_brought_back_to_the_source(trained, directions):
    gaining, bright = with_gain(trained, np.log(1.3)), urushi.diffuse((0.98, 0.77, 0.34))
    free, true = Material(encode(bright, trained).latents, gaining), np.array(bright.reflectance)
    assert (free.directional_albedo(WI) > 1.2 * true).all()
    lawful, rule = COSINES > energy.GRAZING, albedo_rule()
    own = rule.albedo(evaluate_source(bright, rule.wi, rule.wo)[0].T)
    ceiling, _ = energy.albedo_bounds(own, rule)
    material = Material(energy.limit_albedo(gaining, free.latents, ceiling), gaining)
    assert (material.directional_albedo(WI) - true)[lawful].max() < 0.005
    # It is scaled down only as far as the worst angle of the rule requires.
    below = ceiling - code_albedos(gaining, material.latents)
    assert np.abs(below.min(axis=-1)).max() < energy.TOLERANCE
    # One factor for all directions leaves f reciprocal.
    wi, wo = directions[:500], directions[500:]
    above = (wi[:, 2] > 0) & (wo[:, 2] > 0)
    ratio = material.f(wi, wo)[above] / free.f(wi, wo)[above]
    assert np.ptp(ratio, axis=0).max() < 1e-5 and (ratio < 0.9).all()
    assert np.array_equal(material.f(wi, wo), material.f(wo, wi))


def test_codes_that_are_too_bright_at_grazing_angles_change_only_there(trained):
    """A ceiling there moves f at the probes by less than a third of what one factor would."""
    f = np.full((1, len(trained.networks.pairs()[0])), 0.6 / np.pi, np.float32)
    code, cosines = trained.networks.encode(f), albedo_rule().directions[:, 2]
    ceiling, at_probes = np.where(cosines < 0.03, 0.4, 0.9), trained.networks.basis.probe_rows
    apart = []
    for limit in (energy.nearest_within, energy.limit_albedo):
        z = limit(trained, code, ceiling)
        apart.append(np.abs(trained.networks.rest_at_all(z, at_probes) - f).mean())
        # The nearest code weighs the excess against its distance.
        assert (code_albedos(trained, z) < 1.02 * ceiling).all()
    assert apart[0] < 0.3 * apart[1]


@pytest.mark.parametrize("widths", [(0.1,), (0.3, 0.1)])
def test_a_code_reflects_as_much_light_as_its_source(widths):
    """Beckmann lobes, which codes do not represent exactly, as of metals under a coat."""
    kind, names = (
        ("mixture", ("alpha",))
        if len(widths) == 1
        else ("mixture_anisotropic", ("alpha_u", "alpha_v"))
    )
    columns = {"diffuse": 0.1, "ggx_weight": 0.0, "beckmann_weight": 1.0}
    columns |= {"ggx_r0": 0.5, "beckmann_r0": 0.8}
    for lobe in ("ggx", "beckmann"):
        columns |= {f"{lobe}_{n}": x for n, x in zip(names, widths, strict=True)}
    columns = {n: np.float32([columns[n]]) for n in KINDS[kind].parameters}
    model = default_model() if len(widths) == 1 else anisotropic_model()
    rule = albedo_rule(len(widths))

    def source(wi, wo):
        return analytic.at_all(kind, columns, wi, wo)[0]

    pairs, lawful = required_pairs(None, model, table=False), rule.directions[:, 2] > energy.GRAZING
    own = rule.albedo(source(rule.wi, rule.wo)[None])
    codes = codes_of_values(source(*pairs)[None], model)
    free = model.networks.encode(source(*model.networks.pairs())[None])
    off, before = (np.abs(code_albedos(model, z) - own)[:, lawful] for z in (codes, free))
    assert before.max() > 0.015  # otherwise nothing would be tested
    assert off.max() < 0.5 * before.max() and off.mean() < 0.5 * before.mean()


def test_codes_far_below_the_ceiling_keep_their_bits(trained):
    dark = encode(urushi.diffuse(0.3), trained).latents
    np.testing.assert_array_equal(energy.limit_albedo(trained, dark), dark)
    np.testing.assert_array_equal(energy.nearest_within(trained, dark), dark)
    ceiling = code_albedos(trained, dark) + 0.01
    np.testing.assert_array_equal(energy.limit_albedo(trained, dark, ceiling), dark)


@pytest.mark.parametrize("excess", [8.0, 25.0, 70.0])
def test_codes_far_beyond_the_largest_f_are_limited_too(excess, trained):
    """How much a code exceeds its ceiling does not show where f is at the networks' largest."""
    bright = np.array(encode(urushi.diffuse(0.9), trained).latents[:1])
    bright[:, 6] += excess  # the gain, a logarithm
    limited = Material(energy.limit_albedo(trained, bright), trained)
    assert 0.9 < limited.directional_albedo(WI).max() < 1 + BETWEEN


def test_a_source_that_gains_energy_keeps_its_own_albedo(trained):
    """Where its albedo is not known, and under a coat, the ceiling is 1."""

    def bright(wi, wo):
        return np.full(len(wi), 1.2 / np.pi)

    own = encode(bright, trained, table=False)
    albedo = own.directional_albedo(WI)
    assert 1.15 < albedo.max() < 1.2 + BETWEEN
    values = np.full((1, len(trained.networks.pairs()[0])), 1.2 / np.pi)
    blind = Material(codes_of_values(values, trained), trained)
    assert blind.directional_albedo(WI).max() < 1 + BETWEEN
    coated = layer_material(CoatParameters(*map(np.array, (0.1, 1.3, 0, 0, 0))), own, fast=True)
    assert coated.directional_albedo(WI).max() < 1 + BETWEEN


def test_of_many_texels_the_bright_ones_are_limited(trained):
    rng = np.random.default_rng(3)
    bottoms = np.concatenate([
        encode(urushi.diffuse(rho), trained).latents[:1] for rho in (0.2, 0.6, 1.0)
    ])  # fmt: skip
    count = 1800
    coats = CoatParameters(
        alpha=rng.uniform(0.05, 0.5, count),
        eta=np.array(1.5),
        albedo=np.where(rng.random(count) < 0.3, 1.0, 0.5),
        sigma_t=rng.uniform(0, 2, count),
        g=np.array(0.0),
    )
    below = Material(np.tile(bottoms, (count // 3, 1)), trained)
    lifted = np.array(layer_material(coats, below, fast=True).latents)
    trained.networks.gains(lifted)[...] += np.log(1.15)
    limited = energy.limit_albedo(trained, lifted)
    peaks, before = (code_albedos(trained, z[::5]).max(axis=-1) for z in (limited, lifted))
    assert (before > 1).mean() > 0.02  # otherwise the limit would not be tested
    assert peaks.max() <= 1
    untouched = (limited == lifted).all(axis=-1)[::5]
    assert np.array_equal(untouched, before <= 1 - energy.MARGIN)


@pytest.mark.parametrize("bottom", [urushi.conductor(0.1, 0.9), urushi.diffuse(0.5)])
def test_codes_below_a_lower_index_do_not_shine_where_all_light_is_reflected(bottom):
    """There is no rest there: its factor T(wi) T(wo) ends at the critical angle."""
    rng, pairs = np.random.default_rng(4), cosine_pairs(np.random.default_rng(5), 4096)
    below, medium = encode(bottom), {"albedo": 0.6}
    for eta, alpha, depth in rng.uniform([0.5, 0.01, 0], [0.8, 0.05, 5], (3, 3)):
        top, medium["sigma_t"] = urushi.dielectric(alpha, eta=eta), depth
        coated, fast = (layer(top, below, **medium, fast=fast) for fast in (False, True))
        for z in (coated.latents, fast.latents):
            assert code_albedos(below.model, z).max() < 1 + energy.LEAST_REST
        code, table = (x.f(*pairs) for x in (replace(coated, table=None), coated))
        assert np.abs(code - table).sum() < 0.03 * table.sum()
