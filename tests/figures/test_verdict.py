"""The verdict's fits recover what they can say, its kernels are those models, and docs agree."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from benchmarks.rivals import nbrdf
from benchmarks.scenes import LIGHTS
from figures.light.compute import SCENES
from figures.verdict import compute, costs, errors, fits, methods, plot

from urushi.core import direction_sets, error_metrics
from urushi.fan2022 import PaperNetworks
from urushi.fan2022.architecture import AdamProjection, PaperArchitecture, init
from urushi.nets.weights import anisotropic_model, default_model


@pytest.fixture(autouse=True)
def variant():
    mi.set_variant("llvm_ad_rgb")


@pytest.fixture(scope="module")
def found(stored_results):
    return stored_results(
        compute,
        **{
            "weights": default_model(),
            "anisotropic weights": anisotropic_model(),
            "paper weights": PaperNetworks.read(compute.PAPER),
        },
    )


def pairs(count=400):
    return direction_sets.cosine_pairs(np.random.default_rng(5), count, lowest_cosine=0.05)


#: Values in the middle of the ranges, for which no other parameters give nearly the same f.
MATERIALS = {
    fits.PRINCIPLED: {
        "base_color": 0.6, "roughness": 0.5, "metallic": 0.8, "specular": 0.4,
        "clearcoat": 0.7, "clearcoat_gloss": 0.3,
    },
    fits.RECIPE: {
        "base_color": 0.7, "base_metalness": 0.9, "specular_roughness": 0.6, "specular_ior": 1.6,
        "coat_weight": 0.9, "coat_roughness": 0.3, "coat_ior": 1.5, "coat_color": 0.8,
    },
}  # fmt: skip


@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("anisotropic", [False, True])
def test_a_fit_to_a_models_own_values_finds_them_again(name, anisotropic):
    form, parameters = fits.FORMS[name], dict(MATERIALS[name])
    if anisotropic:
        parameters |= dict.fromkeys(form.widths, 0.6)
    parameters |= {colour: np.full(3, parameters[colour]) for colour in form.colours}
    truth = fits.Fitted(form, parameters, anisotropic, 1)
    p = fits.pairs()
    found = fits.fit(form, truth.f(p.wi, p.wo), anisotropic=anisotropic)
    assert found.crossed == anisotropic
    wi, wo = pairs()
    e = error_metrics.stack_error(found.f(wi, wo)[:, 0], truth.f(wi, wo)[:, 0], wi[:, 2], wo[:, 2])
    # Iterations end at a relative change of 1e-4 of the squared error.
    assert e < 0.02


def test_kernels_of_fits_are_the_models_that_are_fitted():
    wi, wo = pairs()
    to_light, to_eye = (mi.Vector3f(np.ascontiguousarray(w.T)) for w in (wi, wo))
    weights = np.random.default_rng(1).normal(size=nbrdf.SIZE) / 4
    both = (
        (costs.ggx_kernel(to_light, to_eye, costs.LOBES), costs.LOBES),
        (costs.nbrdf_kernel(to_light, to_eye, weights), nbrdf.Nbrdf(weights)),
    )
    for kernel, model in both:
        np.testing.assert_allclose(
            np.array(kernel).T, model.f(wi, wo) * wo[:, 2:], rtol=2e-3, atol=1e-5
        )
    dr.sync_thread()


def test_networks_are_reciprocal_and_no_method_but_weidlich_and_wilkies_gains_energy():
    laws = errors.laws(None, fitted=())
    # The albedo's noise over `DIRECTIONS` directions is below a hundredth.
    assert laws[methods.NETWORKS] < 1.01 and laws[methods.BELCOUR] < 1.01
    found = errors.isotropic(2, None, stacks=1, fitted=0)
    assert found[methods.NETWORKS]["exchange"] == 0
    assert found[methods.WEIDLICH]["exchange"] < 1e-5  # rounding
    assert found[methods.BELCOUR]["exchange"] > 1e-3  # its lobes depend on one of the directions
    assert found[methods.NETWORKS]["E"][0] < found[methods.BELCOUR]["E"][0]
    # The model of two widths is that of one where widths are equal, to 1e-5.
    assert found[methods.WEIER]["E"] == pytest.approx(found[methods.BELCOUR]["E"], rel=1e-3)
    assert laws[methods.WEIER] == pytest.approx(laws[methods.BELCOUR], rel=1e-3)


def test_the_papers_system_has_a_row_if_it_has_weights():
    arch = PaperArchitecture(AdamProjection(steps=2, pairs=64))
    untrained = PaperNetworks(arch, init(3), {})
    found = errors.isotropic(2, untrained, stacks=1, fitted=0)
    assert min(found[methods.PAPER]["E"]) > max(found[methods.NETWORKS]["E"])  # it learned nothing
    found |= {f"interfaces_{n}": found for n in compute.INTERFACES}
    assert methods.PAPER in plot.rows(found)


def test_a_single_interface_is_exact_for_networks_and_walk():
    found = errors.isotropic(1, None, stacks=4, fitted=0)
    for name in (methods.NETWORKS, methods.WALK, methods.WEIDLICH):
        assert max(found[name]["E"]) < 1e-5  # rounding


def test_the_stored_results_are_complete(found):
    for n in compute.INTERFACES:
        part = found[f"interfaces_{n}"]
        assert len(part[methods.NETWORKS]["E"]) == errors.STACKS
        assert len(part[fits.GGX]["E"]) == errors.FITTED
        assert max(part["reference"]) < 0.004
    for surface in ("coat", "bottom"):
        part = found[f"anisotropic_{surface}"]
        assert all(len(part[name]) == errors.ANISOTROPIC for name in methods.TWO_WIDTHS)
        assert methods.BELCOUR not in part
    assert len(found["measured"][methods.TABLES]) == errors.BOTTOMS * len(errors.OVER)
    assert {f"{scene}, {light}" for scene in SCENES for light in LIGHTS} < set(found)


def test_over_measured_bottoms_tables_are_closer_than_codes_on_average(found):
    means = {name: np.mean(found["measured"][name]) for name in (methods.TABLES, methods.NETWORKS)}
    assert means[methods.TABLES] < means[methods.NETWORKS]
