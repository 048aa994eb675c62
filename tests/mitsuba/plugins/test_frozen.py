"""Plugins in Dr.Jit's frozen functions, which are recorded once and replayed."""

import gc
import weakref

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, vector

from urushi.core.direction_sets import cosine_pairs
from urushi.material import Material
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


def coat(mi, name: str, networks, textured: bool) -> dict:
    pixels = np.random.default_rng(0).uniform(0.3, 0.8, (4, 4, 3)).astype(np.float32)
    albedo = bitmap(pixels) if textured else 0.7
    extra = {"weights": str(networks)} if name == "neural_layered" else {}
    base = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.3}
    return {"type": name, **COAT, "albedo": albedo, "base": base, **extra}


def saved(model, networks, folder) -> dict:
    codes = np.random.default_rng(0).normal(size=(3, 32))
    codes[:, :6] = [0.2, 0, 0, 1, 1.5, 0]
    Material(codes, model).save(folder / "material.safetensors")
    file = str(folder / "material.safetensors")
    return {"type": "neural_brdf", "filename": file, "weights": str(networks)}


def scene(mi, bsdf, integrator: str = "path"):
    """A sphere under a lamp and a sky."""
    to_world = mi.ScalarTransform4f().look_at([0, -4, 1], [0, 0, 0], [0, 0, 1])
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": integrator, "max_depth": 3},
            "sky": {"type": "constant", "radiance": 0.5},
            "lamp": {"type": "point", "position": [1, -2, 3], "intensity": 8.0},
            "sphere": {"type": "sphere", "bsdf": bsdf},
            "sensor": {
                "type": "perspective",
                "fov": 35,
                "to_world": to_world,
                "film": {"type": "hdrfilm", "width": 16, "height": 16},
            },
        }
    )


def picture(mi, loaded, seed) -> np.ndarray:
    return mi.render(loaded, spp=4, seed=seed)


def replayed(mi, networks) -> dict[str, tuple[dict, dict]]:
    """Materials, and values that their parameters take one after the other."""
    numbers = {"sigma_t.value": (0.5, 1.0, 3.0), "eta": (1.35, 1.4, 1.6)}
    glass = {"type": "roughdielectric", "distribution": "ggx", "int_ior": 1.7}
    two = {"alpha_u": 0.5, "alpha_v": 0.1}
    brushed = {"type": "roughconductor", "distribution": "ggx", **two}
    rough = {"specular_roughness.value": (0.3, 0.5)}
    weight = bitmap(np.random.default_rng(0).uniform(0.3, 0.8, (4, 4, 1)))
    openpbr = {"type": "openpbr", "specular_roughness": 0.3}
    coated = {"coat_weight": weight, "coat_roughness": 0.3, "reference": True}
    coated["energy_compensation"] = False
    found = {}
    for name in LAYERED:
        textured = coat(mi, name, networks, True) | {"energy_compensation": True}
        slab = {"type": name, **COAT, "base": glass}
        found |= {
            f"{name}, constant": (coat(mi, name, networks, False), numbers),
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
    }


@pytest.mark.parametrize(
    "name",
    [f"{x}, {y}" for x in LAYERED for y in ("constant", "compensated texture", "slab")]
    + ["two widths", "openpbr, coat", "openpbr, paper"],
)
def test_replays_use_changed_parameters(rgb, networks, name):
    description, changes = replayed(rgb, networks)[name]
    bsdf = rgb.load_dict(description)
    parameters = rgb.traverse(bsdf)
    wi, wo = cosine_pairs(np.random.default_rng(1), 64)
    u = np.random.default_rng(2).random((3, 64), np.float32)
    numbers = probing.interaction(wi, u[:2].T), vector(wo), rgb.Float(u[0]), rgb.Point2f(u[1:])

    def used(bsdf, si, wo, u, v):
        context = rgb.BSDFContext()
        drawn, weight = bsdf.sample(context, si, u, v)
        return *bsdf.eval_pdf(context, si, wo), drawn.wo, weight

    frozen = dr.freeze(used)
    for values in zip(*changes.values(), strict=True):
        for end, value in zip(changes, values, strict=True):
            parameters[end] = value
        parameters.update()
        gc.collect()
        for found, expected in zip(frozen(bsdf, *numbers), used(bsdf, *numbers), strict=True):
            np.testing.assert_allclose(found.numpy(), expected.numpy(), rtol=1e-4, atol=1e-6)


#: Materials, and a change of their code.
CHANGES = {
    "a medium begins to scatter": (
        {"type": "neural_layered", "int_ior": "air", "sigma_t": 0.8, "base": {"type": "diffuse"}},
        ("albedo.value", 0.8),
    ),
    "an interface appears": (
        {"type": "neural_layered", "int_ior": "air", "sigma_t": 0.8, "base": {"type": "diffuse"}},
        ("eta", 1.4),
    ),
    "total reflection appears": (
        {"type": "neural_layered", "int_ior": 1.4, "ext_ior": 1.0, "base": {"type": "diffuse"}},
        ("eta", 0.7),
    ),
    "fuzz appears": ({"type": "openpbr"}, ("fuzz_weight.value", 0.8)),
}


@pytest.mark.parametrize("name", CHANGES)
def test_replays_follow_changes_of_code(rgb, name):
    """Numbers and flags that code contains as literals: a replay gives what plain code does."""
    description, (key, value) = CHANGES[name]
    bsdf = rgb.load_dict(description)
    si = probing.interaction(np.float32([[0.6, 0, 0.8]]), np.full((1, 2), 0.5))
    wo = rgb.Vector3f(0.0, 0.6, 0.8)
    frozen = dr.freeze(lambda bsdf, si, wo: bsdf.eval(rgb.BSDFContext(), si, wo))
    before, parameters = frozen(bsdf, si, wo).numpy(), rgb.traverse(bsdf)
    parameters[key] = value
    parameters.update()
    expected = bsdf.eval(rgb.BSDFContext(), si, wo).numpy()
    np.testing.assert_allclose(frozen(bsdf, si, wo).numpy(), expected, rtol=1e-4)
    assert not np.allclose(before, expected, rtol=0.01)


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


def test_replays_use_changed_textures(rgb, networks):
    loaded = scene(rgb, coat(rgb, "neural_layered", networks, True))
    parameters = rgb.traverse(loaded)
    frozen = dr.freeze(lambda loaded, seed: picture(rgb, loaded, seed))
    rng = np.random.default_rng(0)
    place = rgb.ScalarTransform3f()
    changes = [
        ("data", lambda: rgb.TensorXf(rng.random((4, 4, 3), np.float32))),
        ("data", lambda: rgb.TensorXf(rng.random((*rng.integers(2, 9, 2), 3), np.float32))),
        ("to_uv", lambda: place.scale(list(rng.uniform(1, 3, 2)))),
    ]
    for index, (name, value) in enumerate(change for change in changes for _ in range(4)):
        parameters[f"sphere.bsdf.albedo.{name}"] = value()
        parameters.update()
        expected = picture(rgb, loaded, rgb.UInt32(index)).numpy()
        found = frozen(loaded, rgb.UInt32(index)).numpy()
        np.testing.assert_allclose(found, expected, rtol=1e-4)
    assert frozen.n_recordings < index  # others are replayed


def test_replays_use_textures_that_begin_to_vary(rgb, networks, few_points):
    """Numbers that are constant in a texture are looked up in no other way than by new code."""
    loaded = scene(rgb, coat(rgb, "neural_layered", networks, True))
    parameters = rgb.traverse(loaded)
    frozen = dr.freeze(lambda loaded: picture(rgb, loaded, 0))
    rng = np.random.default_rng(0)
    for channels in (1, 3, 1):
        for texels in (np.full((4, 4, 3), 0.6), rng.uniform(0.2, 0.8, (4, 4, channels))):
            colours = np.broadcast_to(texels, (4, 4, 3)).astype(np.float32)
            parameters["sphere.bsdf.albedo.data"] = rgb.TensorXf(np.ascontiguousarray(colours))
            parameters.update()
            expected = picture(rgb, loaded, 0).numpy()
            np.testing.assert_allclose(frozen(loaded).numpy(), expected, rtol=1e-4)


@pytest.mark.slow
def test_gradients_inside_equal_those_outside(rgb, networks):
    loaded = scene(rgb, coat(rgb, "neural_layered", networks, False), "prb")
    parameters, key = rgb.traverse(loaded), "sphere.bsdf.alpha.value"

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


@pytest.mark.parametrize("name", (*LAYERED, "neural_brdf"))
def test_updates_inside_are_refused(rgb, networks, model, tmp_path, name):
    if name == "neural_brdf":
        bsdf = saved(model, networks, tmp_path)
        key, value = "sphere.bsdf.latents", dr.ones(rgb.TensorXf, (3, 32))
    else:
        bsdf = coat(rgb, name, networks, False)
        key, value = "sphere.bsdf.alpha.value", rgb.Float(0.5)
    loaded = scene(rgb, bsdf)
    parameters = rgb.traverse(loaded)

    def changed(loaded, parameters, value):
        parameters[key] = value
        parameters.update()
        return picture(rgb, loaded, 0)

    with pytest.raises(RuntimeError, match="frozen") as caught:
        dr.freeze(changed)(loaded, parameters, value)
    causes = [caught.value]
    while causes[-1].__cause__:
        causes.append(causes[-1].__cause__)
    assert f"{name} 'bsdf': its parameters are updated inside a frozen function" in str(causes[-1])


@pytest.mark.parametrize("textured", (False, True))
def test_a_scene_is_freed_without_garbage_collection(rgb, networks, textured):
    """The garbage collector could free reference cycles while a function is recorded, which Dr.Jit
    cannot record."""
    assert not gc.isenabled()
    bsdf = rgb.load_dict(coat(rgb, "neural_layered", networks, textured))
    loaded = scene(rgb, bsdf)
    picture(rgb, loaded, 0).numpy()
    codes = weakref.ref(bsdf.latents)
    del bsdf, loaded
    assert codes() is None


def test_a_plugin_outlives_its_scene(rgb, networks):
    bsdf = rgb.load_dict(coat(rgb, "neural_layered", networks, False))
    first, second = (scene(rgb, bsdf) for _ in range(2))
    expected = picture(rgb, first, 0).numpy()
    del first
    gc.collect()
    found = dr.freeze(lambda loaded: picture(rgb, loaded, 0))(second).numpy()
    np.testing.assert_allclose(found, expected, rtol=1e-4)
