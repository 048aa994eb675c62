"""The paper's networks in the plugins."""

import numpy as np
import pytest

from urushi.fan2022 import blocks
from urushi.fan2022.architecture import PaperArchitecture, init
from urushi.fan2022.proxy import proxy
from urushi.material import Material
from urushi.nets import weights


@pytest.fixture(scope="module")
def networks(tmp_path_factory):
    """Untrained networks with values around 0.3, and proposals that differ."""
    params = init(5)
    params["evaluation.3.bias"] = params["evaluation.3.bias"] + np.float32(0.3)
    params["proxy.4.weight"] = 20 * params["proxy.4.weight"]
    path = tmp_path_factory.mktemp("paper") / "weights.safetensors"
    return weights.save(path, PaperArchitecture(), params, {}), path


def test_blocks_agree_with_numpy(rgb):
    """A skip around a normalised layer, at widths that compile in no time."""
    from drjit import nn

    from urushi.fan2022.kernels import _bound, _chained

    chain = (*blocks.fc("a", 6, 8), *blocks.rb("b", 8), blocks.Linear("c", 8, 2))
    rng = np.random.default_rng(6)
    params = {k: rng.normal(size=s).astype(np.float32) for k, s in blocks.shapes(chain).items()}
    x = rng.normal(size=(100, 6)).astype(np.float32)
    ours = _chained(_bound(params, chain), nn.CoopVec(*(rgb.Float(column) for column in x.T)))
    ours = np.stack([value.numpy() for value in ours], axis=-1)
    expected = blocks.apply(params, chain, x)
    np.testing.assert_allclose(ours, expected, atol=1e-5 * np.abs(expected).max())


def test_proposals_agree_with_numpy(rgb, networks):
    from urushi.fan2022.kernels import Gaussian, PaperSampler

    model, _ = networks
    z = np.random.default_rng(7).normal(size=(50, 32)).astype(np.float32)
    expected = proxy(model.params, z)
    ours = PaperSampler(model).proposal([rgb.Float(column) for column in z.T], 1)
    np.testing.assert_allclose(ours.sigma.numpy(), expected.sigma, rtol=1e-3)
    np.testing.assert_allclose(ours.share.numpy(), expected.share, rtol=1e-3)

    w = np.random.default_rng(8).normal(size=(2, 50, 3))
    w[..., 2] = np.abs(w[..., 2])
    wi, wo = (w / np.linalg.norm(w, axis=-1, keepdims=True)).astype(np.float32)
    u = np.random.default_rng(9).random((50, 3)).astype(np.float32)
    mixture = Gaussian(rgb.Float(expected.sigma), rgb.Float(expected.share))
    vi, vo = (rgb.Vector3f(np.ascontiguousarray(v.T)) for v in (wi, wo))
    np.testing.assert_allclose(mixture.pdf(vi, vo).numpy(), expected.pdf(wi, wo), rtol=1e-3)
    drawn = mixture.sample(vi, rgb.Float(u[:, 0]), rgb.Point2f(*map(rgb.Float, u[:, 1:].T)))
    gaussian = u[:, 0] < expected.share  # the cosine lobes warp the unit square otherwise
    assert gaussian.any()
    there = expected.sample(wi, u)
    np.testing.assert_allclose(drawn.numpy().T[gaussian], there[gaussian], atol=1e-4)


@pytest.mark.slow
def test_a_plate_in_white_light_shows_the_albedo(rgb, networks, tmp_path):
    """16 x 16 pixels through `neural_brdf`; in constant light of one, radiance is the albedo."""
    from urushi.fan2022.kernels import separate_kernels

    model, path = networks
    material = Material(1 + 0.2 * np.random.default_rng(10).normal(size=(3, 32)), model)
    material.save(tmp_path / "material.safetensors")
    files = {"filename": str(tmp_path / "material.safetensors"), "weights": str(path)}
    plate = {"type": "rectangle", "bsdf": {"type": "neural_brdf", **files}}
    camera = {
        "type": "orthographic",
        "to_world": rgb.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]),
        "film": {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}},
    }
    scene = rgb.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 2, "hide_emitters": False},
            "light": {"type": "constant"},
            "plate": plate,
            "camera": camera,
        }
    )
    with separate_kernels():
        image = rgb.render(scene, spp=16).numpy()
    assert image.shape == (16, 16, 3)
    # Untrained networks are not isotropic: integrate over the whole hemisphere, by cosine density.
    u, phi = np.random.default_rng(11).random((2, 16384))
    r, phi = np.sqrt(u), 2 * np.pi * phi
    wo = np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - u)], axis=-1)
    f = np.pi * material.f(np.broadcast_to([0.0, 0.0, 1.0], wo.shape), wo)
    error = np.hypot(image.std(axis=(0, 1)) / 16, f.std(axis=0) / 128)  # of both means
    np.testing.assert_array_less(np.abs(image.mean(axis=(0, 1)) - f.mean(axis=0)), 5 * error)
