"""Plugins in Dr.Jit's frozen functions, which are recorded once and replayed."""

import gc
import weakref

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, spheres, update, vector
from tests.openpbr_surface.probes import WALKS

from urushi.core.direction_sets import cosine_pairs
from urushi.mitsuba.reading import probing
from urushi.mitsuba.recording import signature_of

COAT = {"alpha": 0.2, "int_ior": 1.4, "sigma_t": 0.8, "g": 0.3}
GGX = {"type": "roughconductor", "distribution": "ggx"}
COLOURS = np.random.default_rng(0).uniform(0.3, 0.8, (4, 4, 3)).astype(np.float32)


@pytest.fixture(autouse=True)
def no_garbage():
    """Collect the garbage of other tests, because Dr.Jit ends the process if Python frees its
    arrays while a function is recorded."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


def coat(networks, type="neural_layered", textured=False, **properties) -> dict:
    """A coat by small networks, or `openpbr`, with some texture."""
    if type == "openpbr":
        weight = {"coat_weight": bitmap(COLOURS[..., :1])} if textured else {}
        return {"type": type, **weight, **properties}
    albedo = bitmap(COLOURS) if textured else 0.7
    defaults = COAT | {"albedo": albedo} if "alpha_u" not in properties else {}
    weights = {"weights": str(networks)} if type == "neural_layered" else {}
    return {"type": type, "base": GGX | {"alpha": 0.3}, **defaults, **weights, **properties}


NUMBERS = {"sigma_t.value": (0.5, 1.0, 3.0), "eta": (1.35, 1.4, 1.6)}
FLAT, GREY = np.full((4, 4, 3), 0.6), np.tile(COLOURS[..., :1], 3)
RNG = np.random.default_rng(1)
SIZES = [RNG.random((*size, 3)) for size in ((4, 4), (2, 7), (8, 3))]
GLASS = {"type": "roughdielectric", "distribution": "ggx", "int_ior": 1.7}
TWO_WIDTHS = {"alpha_u": 0.5, "alpha_v": 0.1}
CLEAR = {"albedo": 0.0, "g": 0.0, "base": {"type": "diffuse"}}
OPENPBR = {"type": "openpbr", "specular_roughness": 0.3}
ROUGH = {"specular_roughness.value": (0.3, 0.5)}

#: Properties of coats or of `openpbr`, and values that parameters take one after the other. Those
#: of numbers and flags that code contains as literals need other code.
CHANGES = {
    f"{x}, {kind}": ({"type": x} | properties, values)
    for x in ("layered", "neural_layered")
    for kind, properties, values in (
        ("constant", {}, NUMBERS),
        ("compensated texture", {"textured": True, "energy_compensation": True}, NUMBERS),
        ("slab", {"base": GLASS}, NUMBERS | {"alpha.value": (0.05, 0.1, 0.3)}),
    )
} | {
    "two widths": (
        {"type": "layered", "rotation": 30.0, "base": GGX | TWO_WIDTHS, **TWO_WIDTHS},
        {"alpha_u.value": (0.05, 0.3), "rotation.value": (80.0, 10.0)}
        | {"bottom.alpha_u.value": (0.1, 0.4)},
    ),
    "openpbr, coat": (OPENPBR | {"textured": True, "coat_roughness": 0.3} | WALKS, ROUGH),
    "openpbr, paper": (
        OPENPBR | {"geometry_thin_walled": True, "subsurface_weight": 1.0}, ROUGH,
    ),
    "fuzz appears": ({"type": "openpbr"}, {"fuzz_weight.value": (0.0, 0.8)}),
    "texels": (
        {"textured": True}, {"albedo.data": (FLAT, GREY, FLAT, COLOURS, *SIZES)},
    ),
    "places": ({"textured": True}, {"albedo.to_uv": (1.0, 1.5, 2.5, 1.2)}),
    "a medium begins to scatter": (CLEAR | {"int_ior": "air"}, {"albedo.value": (0.0, 0.8)}),
    "an interface appears": (CLEAR | {"int_ior": "air"}, {"eta": (1.0, 1.4)}),
    "total reflection appears": (CLEAR, {"eta": (1.4, 0.7)}),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGES)
def test_replays_follow_changes(rgb, networks, few_points, name):
    """A replay gives what plain code does, and not what it gave before."""
    properties, values = CHANGES[name]
    bsdf = rgb.load_dict(coat(networks, **properties))
    wi, wo = cosine_pairs(np.random.default_rng(1), 64)
    u = np.random.default_rng(2).random((3, 64), np.float32)
    numbers = probing.interaction(wi, u[:2].T), vector(wo), rgb.Float(u[0]), rgb.Point2f(u[1:])

    def used(bsdf, si, wo, u, v):
        context = rgb.BSDFContext()
        drawn, weight = bsdf.sample(context, si, u, v)
        return *bsdf.eval_pdf(context, si, wo), drawn.wo, weight

    def value(key, x):
        if key.endswith("to_uv"):
            return rgb.ScalarTransform3f().scale([x, 3 - x])
        return rgb.TensorXf(np.float32(x)) if isinstance(x, np.ndarray) else x

    frozen, former = dr.freeze(used), None
    steps = list(zip(*values.values(), strict=True))
    for step in steps:
        update(bsdf, {k: value(k, x) for k, x in zip(values, step, strict=True)})
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

        def __init__(self, flag=False, cache=0, numbers=(1.0,), function=lambda: 1, parts=()):
            self.flag, self.cache, self.function, self.parts = flag, cache, function, parts
            self.numbers = [rgb.Float(numbers), *(np.full(3, x) for x in numbers)]

    def signatures(**attributes) -> list:
        """Of a part, and of a plugin that holds it."""
        part = Part(**attributes)
        return [[type(x) for x in signature_of(y)] for y in (part, Part(parts=({"a": part}, 1.5)))]

    before = signatures()
    assert signatures(cache=1, numbers=(2.0,)) == before
    changes = {"flag": True, "numbers": (1.0, 1.0), "function": lambda: 2, "parts": {"a": 2.5}}
    for name, value in changes.items():
        found = signatures(**{name: value})
        assert found[0] != before[0] and found[1] != before[1], name


@pytest.mark.slow
def test_gradients_inside_equal_those_outside(rgb, networks):
    loaded = rgb.load_dict(spheres(coat(networks), integrator="prb"))
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
    loaded = rgb.load_dict(spheres(coat(networks, "layered")))
    parameters, key = rgb.traverse(loaded), "sphere0.bsdf.alpha.value"

    def changed(loaded, parameters, value):
        parameters[key] = value
        parameters.update()
        return rgb.render(loaded, spp=4)

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
    bsdf = rgb.load_dict(coat(networks, textured=textured))
    loaded = rgb.load_dict(spheres(bsdf))
    rgb.render(loaded, spp=4).numpy()
    codes = weakref.ref(bsdf.latents)
    del bsdf, loaded
    assert codes() is None


def test_a_plugin_outlives_its_scene(rgb, networks):
    bsdf = rgb.load_dict(coat(networks))
    first, second = (rgb.load_dict(spheres(bsdf)) for _ in range(2))
    expected = rgb.render(first, spp=4).numpy()
    del first
    gc.collect()
    found = dr.freeze(lambda loaded: rgb.render(loaded, spp=4))(second).numpy()
    np.testing.assert_allclose(found, expected, rtol=1e-4)
