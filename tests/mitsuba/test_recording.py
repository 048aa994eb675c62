"""Conditions and modes of Dr.Jit: pictures do not depend on how their kernels are recorded."""

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, spheres

from urushi.mitsuba.recording import compiled_once, only_where


def test_no_active_lane_gives_zeros(rgb):
    """Also where Dr.Jit knows that none is active, and leaves the function out."""
    x = dr.arange(rgb.Float, 4)
    for active in (rgb.Bool(False), rgb.Bool([False] * 4)):
        first, (second,) = only_where(active, lambda a: [a + 1, [2 * a]], x)
        for value in (first, second):
            np.testing.assert_array_equal(value.numpy(), np.zeros(len(value)))


def test_a_vertex_is_cached_for_one_context_and_one_interaction(rgb):
    """In one recorded scope: another mask, and an interaction that its owner changes."""
    bsdf = rgb.load_dict({"type": "openpbr"})
    everything, nothing = rgb.BSDFContext(), rgb.BSDFContext()
    nothing.type_mask = 0

    def evaluated(wi, wo):
        si = dr.zeros(rgb.SurfaceInteraction3f)
        si.wi = wi
        found = [bsdf.eval(context, si, wo).x for context in (everything, nothing, everything)]
        si.wi.z *= -1
        return [*found, bsdf.eval(everything, si, wo).x]

    wi, wo = rgb.Vector3f(0.6, 0, 0.8), rgb.Vector3f(0, 0.6, 0.8)
    dr.make_opaque(wi, wo)
    found = [x.numpy()[0] for x in compiled_once(evaluated, wi, wo)]
    assert found[0] == found[2] > 0 and found[1] == found[3] == 0


@pytest.mark.slow
def test_calls_of_one_kernel_or_of_several_render_the_same(rgb, networks):
    """A coat and a textured one, some rays of which leave the scene."""
    albedo = bitmap(np.random.default_rng(0).uniform(0.3, 0.8, (4, 4, 3)))
    coat = {"type": "neural_layered", "weights": str(networks), "alpha": 0.2, "sigma_t": 0.8}
    coat["bottom"] = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.3}
    both = coat | {"albedo": 0.7}, coat | {"albedo": albedo}
    scene = rgb.load_dict(spheres(*both, size=10))
    one = rgb.render(scene, spp=4, seed=3).numpy()
    calls, loops = dr.JitFlag.SymbolicCalls, dr.JitFlag.SymbolicLoops
    with dr.scoped_set_flag(calls, False), dr.scoped_set_flag(loops, False):
        several = rgb.render(scene, spp=4, seed=3).numpy()
    # The same random numbers; sums have another order.
    np.testing.assert_allclose(several, one, rtol=1e-4)
