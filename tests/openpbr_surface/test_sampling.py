"""What `openpbr` samples: weights, and that a vertex of a path is computed once."""

import mitsuba as mi
import numpy as np
import pytest

from urushi.mitsuba.reading import probing

pytestmark = pytest.mark.usefixtures("rgb")

COLOR = {"type": "rgb", "value": [0.2, 0.5, 0.8]}


DARK = {"type": "rgb", "value": [0.02, 0.02, 0.02]}
FUZZ = {"fuzz_weight": 1.0, "base_color": DARK}
GLASS = {"transmission_weight": 1.0, "interior": True}
FILM = {"thin_film_weight": 1.0, "thin_film_ior": 1.8, "thin_film_thickness": 0.4}


@pytest.mark.parametrize(
    ("parameters", "most"),
    [
        # Of both shares, what is below the fuzz has the least weights.
        (FUZZ | {"fuzz_roughness": 0.2}, 1.5),
        (FUZZ | {"fuzz_roughness": 1.0}, 1.5),
        # Light that meets several facets leaves by no lobe of the proposal.
        (GLASS, 5),
        (GLASS | FILM, 5),
        (GLASS | {"specular_roughness": 0.8}, 5),
    ],
)
def test_no_sample_has_a_large_weight(parameters, most):
    """f cos over the density is the albedo, at most one, where the density has the shape of f.

    Light from 20, 50, 65 and 80 degrees, on each side that light comes from.
    """
    bsdf = mi.load_dict({"type": "openpbr", **parameters})
    angles = np.repeat(np.radians([20.0, 50.0, 65.0, 80.0]), 1 << 14)
    u = np.random.default_rng(4).random((3, len(angles)), np.float32)
    modes = mi.TransportMode
    context = mi.BSDFContext(modes.Importance if "interior" in parameters else modes.Radiance)
    for side in (1, -1) if "interior" in parameters else (1,):
        wi = np.stack([np.sin(angles), 0 * angles, side * np.cos(angles)], -1)
        si = probing.interaction(wi, np.full((len(wi), 2), 0.5), np.arange(len(wi)))
        _, weight = bsdf.sample(context, si, mi.Float(u[0]), mi.Point2f(u[1:]))
        assert weight.numpy().max() < most


@pytest.mark.slow
def test_a_path_computes_a_vertex_once(monkeypatch):
    """Light and continuation share the codes and the parameters of the vertex."""
    bsdf = mi.load_dict({"type": "openpbr", "base_color": COLOR, "coat_weight": 1.0})
    calls = []

    def counted(thing, name):
        original = getattr(thing, name)

        def function(*args):
            calls.append(name)
            return original(*args)

        monkeypatch.setattr(thing, name, function)

    for name in ("_vertex", "_f_and_pdf"):
        counted(bsdf.surface, name)
    scene = mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 4},
            "sensor": {"type": "perspective", "film": {"type": "hdrfilm", "width": 4, "height": 4}},
            "shape": {"type": "sphere", "center": [0, 0, 4], "bsdf": bsdf},
            "light": {"type": "constant"},
        }
    )
    assert np.isfinite(np.array(mi.render(scene, spp=1))).all()
    # Towards the light and along the drawn direction, as often as the loop is recorded.
    assert calls and calls.count("_f_and_pdf") == 2 * calls.count("_vertex")
