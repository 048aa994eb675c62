"""What `openpbr` samples: its density, and that a vertex of a path is computed once."""

import mitsuba as mi
import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("rgb")

COLOR = {"type": "rgb", "value": [0.2, 0.5, 0.8]}


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
