"""Refinement brings codes closer to their BRDFs and keeps them suitable for layering."""

import numpy as np
import pytest
from benchmarks.evaluation import benchmark, predict
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import GROUPS

from urushi.checks import CoatParameters
from urushi.core.error_metrics import DARK_OFFSET, huber_loss
from urushi.material import Material, encode, energy
from urushi.material.albedo_rule import albedo_rule
from urushi.material.encode import (
    bare_anchors,
    encoder_codes,
    evaluate_source,
    material_from_values,
)
from urushi.material.fit import (
    ANCHOR_HOLD,
    CODE_HOLD,
    HUBER_KNEE,
    REFINEMENT_STEPS,
    fit_below_ceiling,
    fit_target,
    initial_code,
    levenberg_marquardt,
    refine_codes,
    state_at,
)
from urushi.material.layer import layer, layer_texels
from urushi.nets.interface_fit import find_lobes
from urushi.nets.lobe import NO_LOBE
from urushi.nets.lobe_fit import fit_lobes
from urushi.parallel import one_blas_thread
from urushi.train.distribution import Extended
from urushi.walk import analytic, conductor, dielectric, diffuse


def three_lobes(wi, wo):
    """No kind of BRDF that networks were trained on: narrow, wide and backward lobes and a base."""
    h = wi + wo
    cos_h = h[:, 2] / np.linalg.norm(h, axis=1)
    narrow, wide = (a**2 / (np.pi * (cos_h**2 * (a**2 - 1) + 1) ** 2) for a in (0.05, 0.4))
    backward = np.maximum(np.sum(wi * wo, axis=1), 0) ** 8
    scale = np.array([[0.02, 0.05, 0.3, 0.05], [0.1, 0.1, 0.1, 0.1], [0.3, 0.02, 0.0, 0.2]])
    return np.stack([narrow, wide, backward, np.ones(len(wi))], axis=1) @ scale.T


ODD = (
    three_lobes,
    conductor(0.02, (0.9, 0.5, 0.1)),
    diffuse(0.0),  # black, where the logarithm is critical
    lambda wi, wo: np.full(len(wi), 1e4),
    lambda wi, wo: np.where(wi[:, 2] + wo[:, 2] > 1, 0.3, 0.0),  # values that are exactly zero
)


def values(source, networks) -> np.ndarray:
    """A source's values (C, P) at the probe pairs."""
    f = evaluate_source(source, *networks.pairs()).values
    return np.ascontiguousarray(f.T)


@pytest.mark.parametrize("hold", [ANCHOR_HOLD, CODE_HOLD])
@pytest.mark.parametrize("source", ODD)
def test_no_step_raises_the_objective(source, hold, trained, model):
    for networks in (trained.networks, model.networks):
        for f in values(source, networks):
            lobe = fit_lobes(f)
            z = networks.encode(f[None], lobe[None])[0]
            aim = fit_target(networks, f, None, lobe)
            with one_blas_thread():
                made = [
                    levenberg_marquardt(networks, z, aim, hold, steps)
                    for steps in range(0, REFINEMENT_STEPS + 1, 4)
                ]
                course = [state_at(networks, z, aim, hold).objective for z in made]
            assert (np.diff(course) <= 0).all() and np.isfinite(course).all()


def test_a_code_is_found_again(trained):
    """A decodable function, started from the code of another: its values come back.

    The code itself may differ: it is determined only as far as the values depend on it. Mixtures
    have more than their lobe, which is kept.
    """
    networks = trained.networks
    rng = np.random.default_rng(3)
    f = sampling.evaluate_bottoms(
        Extended(0, "mixture").sample(rng, 12),
        *(np.tile(w, (12, 1, 1)) for w in networks.pairs()),
    )
    truth = networks.encode(f)
    decoded = networks.f(truth[:, None], *networks.pairs())
    lobes = truth[:, : networks.arch.lobe]
    perturbed = networks.encode(decoded * np.exp(0.2 * rng.normal(size=decoded.shape)), lobes)

    def distance(z):
        f_hat = networks.f(z[:, None], *networks.pairs())
        return np.median(np.abs(f_hat - decoded) / (decoded + 1e-3), axis=1)

    with one_blas_thread():
        aims = [fit_target(networks, f, None, lobe) for f, lobe in zip(decoded, lobes, strict=True)]
        found = [
            levenberg_marquardt(networks, z, aim, ANCHOR_HOLD)
            for z, aim in zip(perturbed, aims, strict=True)
        ]
    before, after = distance(perturbed), distance(np.stack(found))
    # Least squares over ten times more values than numbers: at least a factor of two remains of
    # the quadratic convergence even where the prior pulls back to the encoder's own error.
    assert np.mean(after) < 0.5 * np.mean(before)


def test_channels_do_not_depend_on_each_other(trained):
    together = encode(three_lobes, trained, refine=True)
    for channel in range(3):
        alone = encode(lambda *w, c=channel: three_lobes(*w)[:, c], trained, refine=True)
        # Up to rounding: the energy limit decodes the codes of several channels at once, and
        # products of matrices of other sizes add in another order on some processors. Numbers of
        # a code are of order one, so that this is ten steps of a float.
        close = {"rtol": 1e-6, "atol": 1e-6}
        np.testing.assert_allclose(alone.latents[0], together.latents[channel], **close)
        np.testing.assert_allclose(alone.anchors[0], together.anchors[channel], **close)


def test_the_same_every_time(trained):
    first, second = (encode(three_lobes, trained, refine=True) for _ in range(2))
    assert first == second
    assert encode(first, trained, refine=True) is first


@pytest.mark.parametrize("source", ODD)
def test_refined_materials_are_brdfs(source, trained, directions):
    material = encode(source, trained, refine=True)
    above = np.abs(directions) * [1, 1, 1]
    wi, wo = directions.copy(), np.roll(directions, 1, axis=0)
    wi[:, 2], wo[:, 2] = above[:, 2] + 1e-6, np.roll(above[:, 2], 1) + 1e-6
    wi, wo = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in (wi, wo))
    f = material.f(wi, wo)
    assert (f > 0).all() and np.isfinite(f).all()
    assert np.array_equal(f, material.f(wo, wi))


def misses(networks, z, f) -> np.ndarray:
    """The mean differences (C,) of logarithms between codes z (C, L) and values f (C, P)."""
    f_hat = networks.f(z[:, None], *networks.pairs())
    return np.abs(np.log((f_hat + 1e-3) / (f + 1e-3))).mean(axis=1)


def test_a_refined_code_is_closer_than_its_anchor(trained):
    """The less a code is held, the closer it comes."""
    f = values(three_lobes, trained.networks)
    made, encoded = refine_codes(trained.networks, f), trained.networks.encode(f)

    def miss(z: np.ndarray) -> float:
        """What refinement minimises, without the hold: squares, linear where they are large."""
        f_hat = trained.networks.f(z[:, None], *trained.networks.pairs())
        error = np.log((f_hat + DARK_OFFSET) / (f + DARK_OFFSET))
        return huber_loss(error, HUBER_KNEE)[0].mean()

    free, held, one_pass = map(miss, (made.codes, made.anchors, encoded))
    assert free < held < one_pass


def test_no_start_is_worse_than_the_encoder(trained, model):
    """Networks that know nothing get plain surfaces' codes; trained ones keep what they know."""
    for source in ODD:
        for networks in (trained.networks, model.networks):
            f = values(source, networks)
            start = np.stack([initial_code(networks, row, fit_lobes(row)) for row in f])
            encoded = misses(networks, networks.encode(f), f)
            assert (misses(networks, start, f) < encoded + 1e-4).all()  # float32 sums
    known = layer(dielectric(0.1, 1.5), diffuse(0.5), albedo=0.7, sigma_t=1.0, weights=trained)
    f, lobe = values(known, trained.networks)[0], known.latents[0, : trained.arch.lobe]
    start = initial_code(trained.networks, f, lobe)
    assert np.array_equal(start, trained.networks.encode(f[None], lobe[None])[0])


def test_a_far_code_is_replaced_by_a_plain_one(trained):
    """The BRDF is a broad lobe that ends unlike a microfacet lobe; the start must be plausible."""
    cos_h = np.cos(np.linspace(0, np.pi / 2, 7))
    for width in cos_h[1:-1]:

        def bell(wi, wo, width=width):
            h = wi + wo
            tan2 = np.sum(h[:, :2] ** 2, axis=1) / h[:, 2] ** 2
            return 5e-4 + 1.5 * np.exp(-tan2 / (1 - width))

        f = values(bell, trained.networks)[:1]
        start = initial_code(trained.networks, f[0], fit_lobes(f[0]))
        assert misses(trained.networks, start[None], f)[0] < 1


def test_values_at_nodes_bring_the_light_closer(trained):
    """Where a source reflects light, refinement that knows its values there errs less."""
    rule = albedo_rule()
    f, nodes = (
        np.ascontiguousarray(evaluate_source(three_lobes, *pairs).values.T)
        for pairs in (trained.networks.pairs(), (rule.wi, rule.wo))
    )
    light = np.sqrt(nodes * rule.weights * rule.wi[:, 2])

    def error(codes):
        f_hat = trained.networks.f(codes[:, None], rule.wi, rule.wo)
        return np.average(np.abs(np.log(f_hat / nodes)), weights=light)

    with_nodes, without = (error(refine_codes(trained.networks, f, n).codes) for n in (nodes, None))
    assert with_nodes < without


def test_black_nodes_count_for_nothing(trained):
    rule = albedo_rule()
    black = np.zeros(len(trained.networks.pairs()[0]), np.float32)
    none = np.array(NO_LOBE, np.float32)
    aim = fit_target(trained.networks, black, np.zeros(len(rule.wi), np.float32), none)
    assert len(aim.logs) == aim.probes
    grey = np.full(len(rule.wi), 0.1, np.float32)
    nearly_black = fit_target(trained.networks, black + 0.1, grey, none)
    assert nearly_black.weights.sum() == pytest.approx(1)
    assert (nearly_black.weights > 0).all()


def test_layering_over_refined_codes(trained):
    """Simulated lower coats, encoded, refined, and coated once more, against the stored walks.

    A mean over only 28 stacks changes by some per cent with every change of the codes, so a
    difference of a tenth is allowed. Codes without the prior have several times the error.
    """
    groups = tuple(group for group in GROUPS if 2 in group.probed)
    sets = benchmark.read(groups=groups)
    errors = {False: [], True: []}
    for group in groups:
        samples = sets[group.name]
        for refine, found in errors.items():
            lower = material_from_values(samples.probed[1].T, trained, refine=refine).anchors
            table = samples.table
            coat = {
                name: getattr(table, name)[:, 0].astype(np.float64)
                for name in ("alpha", "eta", "albedo", "sigma_t", "g")
            }
            coat["alpha"] = np.maximum(coat["alpha"], 0.01)  # rounded down in single precision
            made = predict.split(
                Material(layer_texels(trained, lower, CoatParameters(**coat)), trained)
            )
            f_hat = predict.evaluate(made, samples.wi, samples.wo)
            found.append(sampling.stack_errors(f_hat, samples))
    before, after = (np.concatenate(errors[refine]).mean() for refine in (False, True))
    assert after < 1.1 * before


def tan2_h(wi, wo):
    """The squared tangent of the half vector's angle to the normal."""
    h = wi + wo
    return np.sum(h[:, :2] ** 2, axis=1) / h[:, 2] ** 2


@pytest.mark.parametrize(
    "source",
    [
        lambda wi, wo: np.where(tan2_h(wi, wo) < 0.1, 0.5, 0.02),
        lambda wi, wo: np.where(tan2_h(wi, wo) < 0.05, 1.0, 0.02),
        lambda wi, wo: 0.2 + np.maximum(np.sum(wi * wo, axis=1), 0) ** 60,
    ],
)
def test_codes_allow_for_the_limit_of_energy(source, trained):
    """Else it would darken all angles for one that is too bright."""
    rule, networks = albedo_rule(), trained.networks
    f, nodes = (
        np.ascontiguousarray(evaluate_source(source, *pairs).values.T)
        for pairs in (networks.pairs(), (rule.wi, rule.wo))
    )
    lobe = fit_lobes(f[0])
    aim, start = fit_target(networks, f[0], nodes[0], lobe), initial_code(networks, f[0], lobe)
    with one_blas_thread():
        codes = [
            way(networks, start, aim, CODE_HOLD) for way in (levenberg_marquardt, fit_below_ceiling)
        ]
    ceiling = energy.albedo_ceiling(rule.albedo(nodes), rule)
    assert (energy.directional_albedos(trained, codes[0][None]) > ceiling + 0.005).any()

    def miss(z: np.ndarray) -> float:
        """The error of a code once it is scaled down to the ceiling."""
        (limited,) = energy.limit_albedo(trained, z[None], ceiling)
        logs = np.log(aim.top + networks.rest(limited, aim.features) + DARK_OFFSET)
        return float(aim.weights @ np.abs(logs - aim.logs))

    free, held = map(miss, codes)
    assert held < free


@pytest.fixture(scope="module")
def plain(trained) -> np.ndarray:
    """Values (12, P) of plain surfaces, three channels each."""
    pairs = trained.networks.pairs()
    metals = conductor(0.03, (0.95, 0.6, 0.3)), conductor(0.5, (0.9, 0.5, 0.1))
    surfaces = (*metals, dielectric(0.1, 1.5), diffuse((0.8, 0.3, 0.05)))
    return np.concatenate([analytic.f(surface, *pairs).T for surface in surfaces])


def test_materials_keep_the_encoders_codes_for_coats(trained, plain):
    """Of metals over a diffuse share, so that the fitted lobe leaves a rest that matters."""
    values = np.float32(0.5) * plain[:3] + np.float32(0.1 / np.pi)
    material = material_from_values(values.T, trained)
    expected = encoder_codes(trained, values, find_lobes(values))
    np.testing.assert_allclose(material.anchors, expected, rtol=1e-4, atol=1e-4)
    assert not np.array_equal(material.anchors, material.latents)


def test_a_lobe_that_is_the_whole_source_has_the_anchor_of_a_bare_surface(trained, plain):
    """The code of its misfit decodes to more than the misfit, so that it is left out."""
    anchors = material_from_values(plain[:3].T, trained).anchors
    assert np.array_equal(anchors, bare_anchors(trained, anchors[:, : trained.arch.lobe]))


@pytest.mark.parametrize("name", ["trained", "model"])
def test_odd_values_have_finite_codes_whatever_the_networks(request, name):
    networks, rng = request.getfixturevalue(name), np.random.default_rng(0)
    pairs = len(networks.networks.pairs()[0])
    odd = [np.zeros(pairs), np.full(pairs, 1e4), 0.3 * (np.arange(pairs) % 2)]
    odd = np.stack([*odd, rng.lognormal(0, 3, pairs)]).astype(np.float32)
    assert np.isfinite(material_from_values(odd.T, networks).latents).all()
