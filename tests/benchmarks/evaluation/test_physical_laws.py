"""Materials come from the public operations, and violations of physical laws are found."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.evaluation import physical_laws, predict
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import Group, Samples

import urushi
from urushi.core.probe_pairs import PROBES, probe_pairs
from urushi.material import Material, energy
from urushi.material.albedo_rule import albedo_rule
from urushi.material.values import material_from_values
from urushi.nets.lobe import of_coat
from urushi.train.distribution import Extended


def of(figures, name):
    return next(figure for figure in figures if figure.name.startswith(name))


@pytest.mark.parametrize("how", ["code", "table", "network"])
def test_materials_are_those_of_the_public_functions(tiny, how):
    """encode, then layer from the lowest coat to the top one, for stacks of two coats."""
    group = Group("two coats", Extended(2, "diffuse"), 2)
    table, (wi, wo) = sampling.draw_stacks(group), sampling.draw_pairs(group)
    nothing = np.zeros(wi.shape[:2], np.float32)
    samples = Samples(table, wi, wo, nothing, nothing)
    f = predict.evaluate(predict.materials(tiny, samples, how=how), wi, wo)
    assert f.shape == wi.shape[:2] and f.dtype == np.float32
    for stack in range(2):
        bottom = urushi.diffuse(float(table.bottom["reflectance"][stack]))
        material = urushi.encode(bottom, tiny, table=how == "table")
        for coat in (1, 0):
            alpha, eta, albedo, sigma_t, g = (
                float(getattr(table, name)[stack, coat])
                for name in ("alpha", "eta", "albedo", "sigma_t", "g")
            )
            top = urushi.dielectric(alpha, eta)
            medium = {"albedo": albedo, "sigma_t": sigma_t, "g": g}
            material = urushi.layer(top, material, fast=how == "network", **medium)
        if how == "code":
            material = replace(material, table=None)
        expected = material.f(wi[stack], wo[stack])[:, 0]
        np.testing.assert_allclose(f[stack], expected, rtol=1e-3)  # tables in half precision


def test_encoded_coats_are_encoded_from_the_stored_values(tiny, sets):
    few, (wi, wo) = sets["few"], tiny.networks.pairs()
    materials = predict.materials(tiny, few, encoded=1)
    for stack in range(3):
        lobe = of_coat(few.table.alpha[stack, :1], few.table.eta[stack, :1])  # it is known
        values = predict.lower_values(few, 1, wi, wo)[stack][:, None]
        expected = material_from_values(values, tiny, lobe=lobe)
        np.testing.assert_allclose(materials[stack].latents, expected.latents, rtol=1e-4, atol=1e-4)


def test_other_probes_are_simulated(sets, monkeypatch):
    """Without stored values for the pairs that networks want, the walk gives them."""
    few = sets["few"]
    monkeypatch.setattr(predict, "STACK_WALKS", 2048)
    bare = Samples(few.table, few.wi, few.wo, few.f, few.se)
    values = predict.lower_values(bare, 1, *probe_pairs(PROBES))
    error = np.abs(values - few.probed[1]) / (few.probed[1] + 1e-3)
    assert np.median(error) < 0.03  # 0.44 / sqrt(2048), the walk's spread in P, is 0.01


def test_lawful_networks_keep_the_laws(sets, tiny):
    """Reciprocity and the sign hold by construction, trained or not."""
    materials = {name: predict.materials(tiny, samples) for name, samples in sets.items()}
    figures = physical_laws.reciprocity_and_sign(sets, materials)
    assert of(figures, "reciprocity").value == 0 and of(figures, "reciprocity").kept
    assert of(figures, "smallest f").value > 0 and of(figures, "smallest f").kept


def test_broken_reciprocity_is_found(sets, tiny, monkeypatch):
    materials = {"few": predict.materials(tiny, sets["few"])}
    monkeypatch.setattr(Material, "f", lambda self, wi, wo: wo[:, 2:] - 0.1)
    figures = physical_laws.reciprocity_and_sign(sets, materials)
    assert of(figures, "reciprocity").value > 800 and not of(figures, "reciprocity").kept
    assert not of(figures, "smallest f").kept


def top_albedos(samples: Samples) -> np.ndarray:
    """Directional albedos of the topmost interfaces of stacks, as `samples.albedo`."""
    table = samples.table
    return np.stack(
        [
            urushi.encode(urushi.dielectric(float(alpha), float(eta))).directional_albedo(
                sampling.albedo_directions()
            )[:, 0]
            for alpha, eta in zip(table.alpha[:, 0], table.eta[:, 0], strict=True)
        ]
    )


@pytest.fixture
def unlimited(monkeypatch):
    """Materials as networks make them, however bright."""
    monkeypatch.setattr(energy, "excesses", lambda model, z, ceiling: np.ones(len(z)))


def test_excess_of_the_albedo(sets, lax, unlimited):
    """The rest, f = 1, has the albedo pi; the topmost interface and the stack are known."""
    materials = {name: predict.materials(lax, samples) for name, samples in sets.items()}
    figures = physical_laws.albedo_excess(sets, materials)
    few = sets["few"]
    above = np.pi + top_albedos(few) - few.albedo
    assert of(figures, "  with its noise").value == pytest.approx(100 * above.max(), abs=0.2)
    assert of(figures, "albedo above").kept is False
    assert of(figures, "  mean absolute").value == pytest.approx(100 * above.mean(), abs=0.2)


def test_white_albedo(lax, monkeypatch, unlimited):
    monkeypatch.setattr(physical_laws, "WHITE_STACKS", 1)
    value = physical_laws.white_albedo(lax).value / 100
    assert np.pi < value <= np.pi + 1  # a topmost interface reflects at most everything


def test_energy_is_conserved_by_any_networks(sets, lax, monkeypatch):
    monkeypatch.setattr(physical_laws, "WHITE_STACKS", 1)
    assert physical_laws.white_albedo(lax).kept
    materials = {"bare": predict.materials(lax, sets["bare"])}
    bare = sets["bare"]
    own = [albedo_rule().albedo(f) for f in predict.lower_values(bare, 0, *albedo_rule()[:2])]
    for material, albedo in zip(materials["bare"], own, strict=True):
        excess = energy.directional_albedos(lax, material.latents)[0] - albedo
        lawful = albedo_rule().cosines > energy.GRAZING
        assert excess[lawful].max() < energy.SLACK + 1e-5


def test_vanishing_coat(sets, lax, unlimited):
    """Networks that always answer 1 are as far from every bottom as 1 is."""
    figure = physical_laws.vanishing_coat(lax, sets)
    ones = np.ones_like(sets["bare"].f)
    expected = sampling.stack_errors(ones, sets["bare"]).mean()
    assert figure.value == pytest.approx(100 * expected, rel=1e-3) and not figure.kept


def test_the_reference_itself_tends_to_the_bottom(sets):
    """The coat that networks should make vanish does vanish, in E, in the simulator."""
    bare = sets["bare"]
    shape = (len(bare.table), 1)
    coats = {
        name: np.full(shape, x, np.float32) for name, x in physical_laws.VANISHING._asdict().items()
    }
    table = type(bare.table)(**coats, kind=bare.table.kind, bottom=bare.table.bottom)
    f, _ = sampling.walk_all(table, bare.wi, bare.wo, 1024, seed=3)
    # Grazing pairs lose some light by the shadowing of even the smoothest interface.
    assert (sampling.stack_errors(f, bare) < physical_laws.VANISHING_ERROR).all()


def test_a_constant_never_rises_with_absorption(lax):
    share, rise, albedo = physical_laws.absorption(lax, stacks=1)
    assert share.kept and share.value == rise.value == albedo.value == 0


def test_f_that_rises_with_absorption_is_found(tiny, monkeypatch):
    def brighter(coat, bottom):
        codes = np.array(bottom.latents)
        codes[:, tiny.arch.lobe :] = 0
        return Material(tiny.networks.rest_scaled(codes, 1 + coat.sigma_t), tiny)

    monkeypatch.setattr(predict, "coated", brighter)
    share, rise, albedo = physical_laws.absorption(tiny, stacks=1)
    assert not share.kept and 50 < share.value <= 100 and rise.value > 0 and albedo.value > 0
