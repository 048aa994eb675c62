"""Plugins in Dr.Jit's frozen functions, which are recorded once and replayed."""

import gc
import weakref

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, spheres, update, vector

from urushi.core.direction_sets import cosine_pairs
from urushi.mitsuba.reading import probing
from urushi.mitsuba.recording import signature_of

LAYERED = "layered", "neural_layered"
COAT = {"alpha": 0.2, "int_ior": 1.4, "albedo": 0.7, "sigma_t": 0.8, "g": 0.3}


@pytest.fixture(autouse=True)
def no_garbage():
    """Collect the garbage of other tests, because Dr.Jit ends the process if Python frees its
    arrays while a function is recorded."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


def coat(name: str, networks, textured: bool) -> dict:
    pixels = np.random.default_rng(0).uniform(0.3, 0.8, (4, 4, 3)).astype(np.float32)
    albedo = bitmap(pixels) if textured else 0.7
    extra = {"weights": str(networks)} if name == "neural_layered" else {}
    base = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.3}
    return {"type": name, **COAT, "albedo": albedo, "base": base, **extra}


def picture(mi, loaded, seed=0) -> np.ndarray:
    return mi.render(loaded, spp=4, seed=seed)


def changes(mi, networks) -> dict[str, tuple[dict, dict]]:
    """Materials, and values that their parameters take one after the other.

    Those of numbers and flags that code contains as literals need other code.
    """
    numbers = {"sigma_t.value": (0.5, 1.0, 3.0), "eta": (1.35, 1.4, 1.6)}
    glass = {"type": "roughdielectric", "distribution": "ggx", "int_ior": 1.7}
    two = {"alpha_u": 0.5, "alpha_v": 0.1}
    brushed = {"type": "roughconductor", "distribution": "ggx", **two}
    rough = {"specular_roughness.value": (0.3, 0.5)}
    rng = np.random.default_rng(0)
    weight = bitmap(rng.uniform(0.3, 0.8, (4, 4, 1)))
    openpbr = {"type": "openpbr", "specular_roughness": 0.3}
    coated = {"coat_weight": weight, "coat_roughness": 0.3, "reference": True}
    coated["energy_compensation"] = False
    clear = {"type": "neural_layered", "sigma_t": 0.8, "base": {"type": "diffuse"}}
    flat, rows = np.full((4, 4, 3), 0.6), rng.uniform(0.2, 0.8, (4, 4, 1))
    grey, texels = np.tile(rows, 3), rng.uniform(0.2, 0.8, (4, 4, 3))
    sizes = [rng.random((*size, 3)) for size in ((4, 4), (4, 4), (2, 7), (8, 3))]
    scales = [mi.ScalarTransform3f().scale([x, 3 - x]) for x in (1.0, 1.5, 2.5, 1.2)]
    data = [mi.TensorXf(np.float32(x)) for x in (flat, grey, flat, texels, flat, grey, *sizes)]
    found = {
        "texels": (coat("neural_layered", networks, True), {"albedo.data": data}),
        "places": (coat("neural_layered", networks, True), {"albedo.to_uv": scales}),
    }
    for name in LAYERED:
        textured = coat(name, networks, True) | {"energy_compensation": True}
        slab = {"type": name, **COAT, "base": glass}
        found |= {
            f"{name}, constant": (coat(name, networks, False), numbers),
            f"{name}, compensated texture": (textured, numbers),
            f"{name}, slab": (slab, numbers | {"alpha.value": (0.05, 0.1, 0.3)}),
        }
    return found | {
        "two widths": (
            {"type": "layered", **two, "rotation": 30.0, "base": brushed},
            {"alpha_u.value": (0.05, 0.3), "rotation.value": (80.0, 10.0)}
            | {"bottom.alpha_u.value": (0.1, 0.4)},
        ),
        "openpbr, coat": (openpbr | coated, rough),
        "openpbr, paper": (
            openpbr | {"geometry_thin_walled": True, "subsurface_weight": 1.0},
            rough,
        ),
        "a medium begins to scatter": (clear | {"int_ior": "air"}, {"albedo.value": (0.0, 0.8)}),
        "an interface appears": (clear | {"int_ior": "air"}, {"eta": (1.0, 1.4)}),
        "total reflection appears": (clear, {"eta": (1.4, 0.7)}),
        "fuzz appears": ({"type": "openpbr"}, {"fuzz_weight.value": (0.0, 0.8)}),
    }


@pytest.mark.parametrize(
    "name",
    [f"{x}, {y}" for x in LAYERED for y in ("constant", "compensated texture", "slab")]
    + ["two widths", "openpbr, coat", "openpbr, paper", "texels", "places"]
    + ["a medium begins to scatter", "an interface appears", "total reflection appears"]
    + ["fuzz appears"],
)
def test_replays_follow_changes(rgb, networks, few_points, name):
    """A replay gives what plain code does, and not what it gave before."""
    description, values = changes(rgb, networks)[name]
    bsdf = rgb.load_dict(description)
    wi, wo = cosine_pairs(np.random.default_rng(1), 64)
    u = np.random.default_rng(2).random((3, 64), np.float32)
    numbers = probing.interaction(wi, u[:2].T), vector(wo), rgb.Float(u[0]), rgb.Point2f(u[1:])

    def used(bsdf, si, wo, u, v):
        context = rgb.BSDFContext()
        drawn, weight = bsdf.sample(context, si, u, v)
        return *bsdf.eval_pdf(context, si, wo), drawn.wo, weight

    frozen, former = dr.freeze(used), None
    steps = list(zip(*values.values(), strict=True))
    for step in steps:
        update(bsdf, dict(zip(values, step, strict=True)))
        gc.collect()
        found, expected = ([x.numpy() for x in run(bsdf, *numbers)] for run in (frozen, used))
        for replayed, plain in zip(found, expected, strict=True):
            np.testing.assert_allclose(replayed, plain, rtol=1e-4, atol=1e-6)
        assert former is None or not np.allclose(expected[0], former, rtol=0.001)
        former = expected[0]
    if name == "texels":
        assert frozen.n_recordings < len(steps)  # others are replayed


def test_a_signature_has_every_attribute(rgb):
    """Whatever is in a plugin, but for the numbers in arrays, which code reads from memory."""

    class Part:
        UNRECORDED = ("cache",)

        def __init__(self):
            self.flag, self.cache, self.numbers = False, 0, [rgb.Float(1), np.zeros(3)]
            self.function = lambda: self.flag

    plugin = Part()
    plugin.part = (Part(), {"a": 1.5})

    def kinds():
        return [type(x) for x in signature_of(plugin)]

    before = kinds()
    plugin.cache, plugin.numbers = 1, [rgb.Float(2), np.ones(3)]
    assert kinds() == before
    changes = [
        lambda: setattr(plugin.part[0], "flag", True),
        lambda: plugin.part[1].update(a=2.5),
        lambda: plugin.numbers.append(rgb.Float(1)),
        lambda: setattr(plugin, "numbers", None),
        lambda: setattr(plugin, "function", lambda: True),
    ]
    for change in changes:
        change()
        before, former = kinds(), before
        assert before != former


@pytest.mark.slow
def test_gradients_inside_equal_those_outside(rgb, networks):
    loaded = rgb.load_dict(spheres(coat("neural_layered", networks, False), integrator="prb"))
    parameters, key = rgb.traverse(loaded), "sphere0.bsdf.alpha.value"

    def step(loaded, parameters, seed):
        loss = dr.mean(rgb.render(loaded, parameters, spp=4, seed=seed), axis=None)
        dr.backward(loss)
        return loss

    frozen = dr.freeze(step)
    for index in range(4):  # the first are recorded, the others replayed
        found = []
        for function in (step, frozen):
            parameters[key] = dr.detach(parameters[key]) * (0.95 if function is step else 1)
            dr.enable_grad(parameters[key])
            parameters.update()
            loss = function(loaded, parameters, rgb.UInt32(index))
            found.append([np.ravel(loss.numpy()), np.ravel(parameters[key].grad.numpy())])
        for plain, replayed in zip(*found, strict=True):
            assert np.abs(plain).max() > 0
            np.testing.assert_allclose(replayed, plain, rtol=1e-4, atol=1e-5 * np.abs(plain).max())
    assert frozen.n_recordings < 4


def test_updates_inside_are_refused(rgb, networks):
    loaded = rgb.load_dict(spheres(coat("layered", networks, False)))
    parameters, key = rgb.traverse(loaded), "sphere0.bsdf.alpha.value"

    def changed(loaded, parameters, value):
        parameters[key] = value
        parameters.update()
        return picture(rgb, loaded)

    with pytest.raises(RuntimeError, match="frozen") as caught:
        dr.freeze(changed)(loaded, parameters, rgb.Float(0.5))
    causes = [caught.value]
    while causes[-1].__cause__:
        causes.append(causes[-1].__cause__)
    assert "layered 'bsdf': its parameters are updated inside a frozen function" in str(causes[-1])


@pytest.mark.parametrize("textured", (False, True))
def test_a_scene_is_freed_without_garbage_collection(rgb, networks, textured):
    """The garbage collector could free reference cycles while a function is recorded, which Dr.Jit
    cannot record."""
    assert not gc.isenabled()
    bsdf = rgb.load_dict(coat("neural_layered", networks, textured))
    loaded = rgb.load_dict(spheres(bsdf))
    picture(rgb, loaded).numpy()
    codes = weakref.ref(bsdf.latents)
    del bsdf, loaded
    assert codes() is None


def test_a_plugin_outlives_its_scene(rgb, networks):
    bsdf = rgb.load_dict(coat("neural_layered", networks, False))
    first, second = (rgb.load_dict(spheres(bsdf)) for _ in range(2))
    expected = picture(rgb, first).numpy()
    del first
    gc.collect()
    found = dr.freeze(lambda loaded: picture(rgb, loaded))(second).numpy()
    np.testing.assert_allclose(found, expected, rtol=1e-4)
