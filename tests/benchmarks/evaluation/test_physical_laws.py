"""Materials come from the public operations, and violations of physical laws are found."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.evaluation import physical_laws, predict
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import Group, Samples

import urushi
from urushi.material import Material
from urushi.train.distribution import Extended


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


def test_broken_reciprocity_is_found(sets, tiny, monkeypatch):
    materials = {"few": predict.materials(tiny, sets["few"])}
    monkeypatch.setattr(Material, "f", lambda self, wi, wo: wo[:, 2:] - 0.1)
    *_, reciprocity, smallest = physical_laws.reciprocity_and_sign(sets, materials)
    assert reciprocity.value > 800 and not reciprocity.kept and not smallest.kept


def test_f_that_rises_with_absorption_is_found(tiny, monkeypatch):
    def brighter(coat, bottom):
        codes = np.array(bottom.latents)
        codes[:, tiny.arch.lobe :] = 0
        tiny.networks.gains(codes)[...] += np.log(1 + coat.sigma_t)
        return Material(codes, tiny)

    monkeypatch.setattr(physical_laws, "layer_material", brighter)
    share, rise, albedo = physical_laws.absorption(tiny, stacks=1)
    assert not share.kept and 50 < share.value <= 100 and rise.value > 0 and albedo.value > 0
