"""What `openpbr` samples: weights, and that a vertex of a path is computed once."""

from unittest.mock import Mock

import mitsuba as mi
import numpy as np
import pytest
from tests.mitsuba.probes import sampled, spheres
from tests.openpbr_surface.probes import loaded, toward

pytestmark = pytest.mark.usefixtures("rgb")

FUZZ = {"fuzz_weight": 1.0, "base_color": (0.02, 0.02, 0.02)}
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
    bsdf, mode = loaded(**parameters), "Importance" if "interior" in parameters else "Radiance"
    for side in (1, -1) if "interior" in parameters else (1,):
        wi = np.stack([toward(side * np.cos(np.radians(x)), 0.0) for x in (20, 50, 65, 80)])
        assert sampled(bsdf, wi, 1 << 14, mode=mode)[0].max() < most


@pytest.mark.slow
def test_a_path_computes_a_vertex_once(monkeypatch):
    """Light and continuation share the codes and the parameters of the vertex."""
    bsdf, calls = loaded(coat_weight=1.0), {}
    for name in ("_vertex", "_f_and_pdf"):
        calls[name] = Mock(side_effect=getattr(bsdf.surface, name))
        monkeypatch.setattr(bsdf.surface, name, calls[name])
    picture = mi.render(mi.load_dict(spheres(bsdf, size=4)), spp=1)
    assert np.isfinite(np.array(picture)).all()
    # Towards the light and along the drawn direction, as often as the loop is recorded.
    assert calls["_vertex"].call_count
    assert calls["_f_and_pdf"].call_count == 2 * calls["_vertex"].call_count
