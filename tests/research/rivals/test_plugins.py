"""The plugins `layered_belcour` and `layered_weidlich` against their models in NumPy; samples."""

import numpy as np
import pytest
from gallery import stage
from research.rivals import belcour, plugins, weidlich
from tests.directions import above
from tests.mitsuba import sampling
from tests.mitsuba.probes import f

import urushi

GOLD = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2, "eta": 0.2, "k": 3.9}
COAT = {"type": "layered_belcour", "int_ior": 1.5, "ext_ior": 1.0}
COLOURS = (0.1, 1.0, 3.0)


@pytest.fixture(scope="module", autouse=True)
def registered():
    plugins.register()


BOTTOMS = {
    "conductor": (GOLD, urushi.conductor(0.2, eta=0.2, k=3.9)),
    "diffuse": (stage.diffuse(0.9, 0.5, 0.1), urushi.diffuse((0.9, 0.5, 0.1))),
}


@pytest.mark.parametrize(
    ("model", "kind", "medium", "widths", "tolerance"),
    [
        # Rounding, and a table of metals that is within 0.007.
        (belcour, "conductor", {"albedo": 0.6, "g": 0.4}, {"alpha": 0.4}, 0.01),
        (belcour, "diffuse", {"albedo": 0.6, "g": 0.4}, {"alpha": 0.4}, 0.01),
        (weidlich, "conductor", {}, {"alpha_u": 0.4, "alpha_v": 0.2}, 1e-3),
    ],
    ids=["belcour, metal", "belcour, diffuse", "weidlich"],
)
def test_values_are_the_models(rgb, model, kind, medium, widths, tolerance):
    """Of a coat, and of two, the upper one of a lower index."""
    wi, wo = (above(3000, seed, 0.05) for seed in (0, 1))
    nested, described = BOTTOMS[kind]
    coat = COAT | {"type": f"layered_{model.__name__.rpartition('.')[2]}"}
    plugin = coat | medium | {"alpha": 0.1, "sigma_t": stage.rgb(*COLOURS), "base": nested}
    stack = urushi.coat(described, 0.1, 1.5, **({"albedo": 0.0} | medium), sigma_t=COLOURS)
    twice = coat | widths | {"int_ior": 0.8, "base": plugin | {"int_ior": 1.2, "ext_ior": 0.8}}
    for bsdf, layers in (plugin, stack), (twice, urushi.coat(stack, eta=0.8, **widths)):
        expected = model.f(layers, wi, wo)
        np.testing.assert_allclose(f(rgb.load_dict(bsdf), wi, wo), expected, tolerance, 1e-5)


def test_samples_follow_the_normalised_density(rgb):
    """Of smooth and rough coats, over metal, a Lambertian surface, black, and another coat."""
    scattering = {"sigma_t": stage.rgb(*COLOURS), "albedo": 0.9, "g": 0.2}
    narrow = GOLD | {"alpha": 0.02}
    black = {"type": "diffuse", "reflectance": 0.0}
    first = COAT | {"alpha": 0.01, "base": narrow}
    coats = {
        0: first,
        45: COAT | {"alpha": 0.3, "base": {"type": "diffuse"}},
        70: COAT | scattering | {"alpha": stage.rgb(0.05, 0.1, 0.4), "base": GOLD},
        89: COAT | {"alpha": 0.6, "int_ior": 0.7, "base": black},
        20: COAT | scattering | {"alpha": 0.2, "int_ior": 1.9, "base": first},
        60: COAT | {"alpha": 0.05, "sigma_t": 20.0, "base": narrow},
    }
    for degrees, coat in coats.items():
        sampling.check(rgb.load_dict(coat), [degrees], len(coats))
