"""The reference of held-out stacks has the stated error and is independent of training data."""

import numpy as np
import pytest
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.distributions import Table2
from benchmarks.evaluation.samples import GROUPS, ROWS, Group, Samples
from benchmarks.quality import benchmark_set

from urushi.core.probe_pairs import PROBES, probe_pairs
from urushi.core.quadrature import half_vector_rule
from urushi.errors import ParameterError
from urushi.train.distribution import Extended
from urushi.walk import coat, conductor
from urushi.walk.simulate import albedo


def test_the_reference_reaches_its_aim(sets, aim):
    """E of the noise is at most the aim, and a third for the error of the pilot run's noise."""
    own_e, own_p = sampling.reference_error(sets["few"])
    assert (own_e < 1.3 * aim).all()
    assert np.median(own_p) < aim


def test_another_reference_of_the_same_stacks_agrees(sets):
    """An independent run has just the noise of both: E|n| <= sqrt(2) of one's root mean square."""
    first = sets["few"]
    f, se = sampling.walk_all(first.table, first.wi, first.wo, 8192, seed=99)
    again = Samples(first.table, first.wi, first.wo, f, se)
    own, other = sampling.reference_error(first)[0], sampling.reference_error(again)[0]
    assert (sampling.stack_errors(f, first) < 1.5 * (own + other)).all()
    assert (sampling.stack_errors(first.f, first) == 0).all()
    assert (sampling.pair_errors(first.f, first) == 0).all()


def test_fewest_walks_for_an_error():
    """No other allotment of the same total has less noise in E (Hölder's inequality)."""
    rng = np.random.default_rng(1)
    count = sampling.E_PAIRS + sampling.P_PAIRS
    f, sd = rng.uniform(0.1, 2, (2, 1, count))
    cosines = rng.uniform(0.1, 1, (2, 1, count))
    walks = benchmark_set._walks_for_errors(f, sd, *cosines)[0, : sampling.E_PAIRS]
    noise = (sd * cosines[0] * cosines[1])[0, : sampling.E_PAIRS]
    energy = (f * cosines[0] * cosines[1])[0, : sampling.E_PAIRS].sum()
    error = (noise / np.sqrt(walks)).sum() / energy
    assert error == pytest.approx(benchmark_set.E_ERROR, rel=1e-9)
    for _ in range(20):
        other = walks * rng.uniform(0.8, 1.25, walks.shape)
        other *= walks.sum() / other.sum()
        assert (noise / np.sqrt(other)).sum() / energy > error


def test_probed_values_are_those_of_the_lower_stack():
    """A stack of two coats, less its top one, is simulated at the probes as a stack of its own."""
    table = sampling.draw_stacks(Group("g", Extended(2, "diffuse"), 4))
    lower = sampling.lowest(table, 1)
    np.testing.assert_array_equal(lower.alpha, table.alpha[:, 1:])
    np.testing.assert_array_equal(lower.bottom["reflectance"], table.bottom["reflectance"])
    assert sampling.lowest(table, 0).coats == 0
    assert len(benchmark_set.first(table, 3)) == 3


def test_probed_values_agree_with_the_stack(sets):
    """The probes' values, within the noise of both: P's median at 8192 walks is below 1 %."""
    few = sets["few"]
    probes = probe_pairs(PROBES)
    wi, wo = (np.broadcast_to(w, (3, *w.shape)) for w in probes)
    f, _ = sampling.walk_all(few.table, wi, wo, 8192, seed=5)
    error = np.abs(f - few.probed[1]) / (few.probed[1] + 1e-3)
    assert np.median(error) < 0.015


def test_albedo_agrees_with_the_one_by_importance_sampling(sets):
    """Two estimators of the hemispherical integral; the quadrature is good to 0.001."""
    few = sets["few"]
    wi = sampling.albedo_directions()
    for stack in range(3):
        bottom = conductor(few.table.bottom["alpha"][stack], few.table.bottom["r0"][stack])
        names = ("alpha", "eta", "albedo", "sigma_t", "g")
        described = coat(bottom, *(getattr(few.table, name)[stack, 0] for name in names))
        other, se = albedo(described, wi, walks=1 << 15)
        noise = np.hypot(se[:, 0], few.albedo_se[stack])
        assert (np.abs(other[:, 0] - few.albedo[stack]) < 4 * noise + 0.002).all()


def test_bare_bottoms_are_exact(sets):
    bare = sets["bare"]
    assert not bare.se.any() and bare.albedo is None
    np.testing.assert_array_equal(bare.f, sampling.evaluate_bottoms(bare.table, bare.wi, bare.wo))


def test_other_seeds_and_names_give_other_stacks(groups):
    first = sampling.draw_stacks(groups[0])
    for other in (
        sampling.draw_stacks(groups[0], seed=1),
        sampling.draw_stacks(Group("other", Table2(1), 3)),
    ):
        assert not np.isin(other.alpha, first.alpha).any()
    pairs = sampling.draw_pairs(groups[0])[0], sampling.draw_pairs(groups[0], seed=1)[0]
    assert not np.isin(pairs[0][..., 0], pairs[1][..., 0]).all()


def test_rows_are_made_of_groups_that_exist():
    names = [group.name for group in GROUPS]
    assert len(set(names)) == len(names)
    assert {name for row in ROWS for name in row.groups} == set(names)
    by_name = {group.name: group for group in GROUPS}
    for row in ROWS:
        for name in row.groups:
            coats = row.coats(by_name[name])
            assert coats == 0 or coats in by_name[name].probed


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Group("none", Table2(), 0), "group 'none' has 0 stacks; it needs at least one"),
        (lambda: Group("deep", Table2(1), 3, probed=(2,)), "probed = \\(2,\\)"),
    ],
)
def test_bad_groups(make, message):
    with pytest.raises(ParameterError, match=message):
        make()


def test_the_albedo_rule_is_that_of_materials():
    """Lambertian 1 / pi integrates to one over every incident direction."""
    wo, weights = half_vector_rule(sampling.albedo_directions())
    np.testing.assert_allclose((weights * wo[..., 2] / np.pi).sum(-1), 1, atol=1e-3)
