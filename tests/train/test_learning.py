"""The networks can overfit one BRDF, and the proposal learns to follow it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from urushi.core.direction_sets import training_pairs
from urushi.core.probe_pairs import probe_pairs
from urushi.nets.architecture import Architecture, init
from urushi.nets.encoder import input_statistics
from urushi.nets.features import direction_features
from urushi.nets.lobe import NO_LOBE
from urushi.nets.proposal import mixture_pdf, sample_mixture
from urushi.train.batches import Batch
from urushi.train.losses import compose
from urushi.train.optimiser import Schedule, compile_steps, start
from urushi.train.stages import sampling
from urushi.train.stages.joint import joint_loss
from urushi.train.stages.sampling import sampler_loss
from urushi.walk import analytic, conductor

pytestmark = pytest.mark.research

ARCH = Architecture(
    latent=10, decoder=(32, 32), encoder=(8,), layerer=(4,), sampler=(16,), probes=32
)
#: The networks have to learn the metal: its lobe is not given.
LOBES = np.array([NO_LOBE], np.float32)
GOLD = conductor(alpha=0.2, r0=0.8)


def gold(wi, wo):
    return analytic.f(GOLD, wi, wo)[:, 0]


@pytest.fixture(scope="module")
def overfitted():
    """Networks trained on one conductor, its probe values, and the last error."""
    schedule = Schedule(1000, 20, 1e-2, average=0.9, steps_per_call=50, checkpoint_every=50)
    wi, wo = training_pairs(np.random.default_rng(0), 1024)
    probes = gold(*probe_pairs(ARCH.probes))[None]
    f = gold(wi, wo)[None]
    batch = Batch(LOBES, probes, (), direction_features(wi, wo)[None], np.zeros_like(f), f)
    batches = jax.tree.map(lambda x: np.repeat(x[None], 50, axis=0), batch)
    features = jnp.asarray(direction_features(*probe_pairs(ARCH.probes)))
    fixed = input_statistics(probes)

    def loss(trained, one):
        return joint_loss({**trained, **fixed}, ARCH, one, features)

    steps = compile_steps(loss, schedule)
    state = start({k: v for k, v in init(ARCH, 0).items() if k not in fixed}, schedule)
    for _ in range(schedule.steps // 50):
        state, terms = steps(state, batches)
    return {**state.average, **fixed}, probes, float(terms["fit"])


def test_one_brdf_can_be_overfitted(overfitted):
    # A mean squared relative error of 1e-4 is one per cent: GGX is nearly linear in the features.
    assert overfitted[2] < 1e-4


def variation(params, arch, latents, *, seed: int, materials: int) -> np.ndarray:
    """Coefficient of variation (materials,) of f cos_o / pdf over 4,096 samples of the proposal."""
    keys = jax.random.split(jax.random.key(seed), 3)
    z = sampling.pick_materials(keys[0], latents, materials)
    u = jax.random.uniform(keys[1], (materials, 2)) * jnp.array([85 / 88, 1.0])
    wi = sampling.incoming_directions(u, arch.widths)[:, None]

    def one(z, wi, key):
        weights, alphas = sampling.propose(params, arch, jnp.mean(z, axis=0), wi[0])
        wo = sample_mixture(weights, alphas, wi, jax.random.uniform(key, (4096, 3)))
        p = mixture_pdf(weights, alphas, wi, wo)
        f_cos = sampling.mean_f_cos(params, arch, z[None], wi[None], wo[None])[0]
        ratio = jnp.where(p > 0, f_cos / jnp.where(p > 0, p, 1), 0)
        return jnp.std(ratio) / jnp.mean(ratio)

    per_material = jax.random.split(keys[2], materials)
    return np.asarray(jax.lax.map(lambda entry: one(*entry), (z, wi, per_material)))


def test_the_proposal_learns_its_lobe(overfitted):
    params, probes, _ = overfitted
    latents = compose(params, ARCH, jnp.asarray(LOBES), jnp.asarray(probes), ())
    before = variation(params, ARCH, latents, seed=1, materials=16)
    schedule = Schedule(200, 10, 1e-2, average=0.9, steps_per_call=50, checkpoint_every=50)
    scene = params, latents, jax.random.key(0)
    steps = compile_steps(lambda p, step: sampler_loss(p, ARCH, *scene, step), schedule)
    sampler = {name: value for name, value in params.items() if name.startswith("sampler.")}
    state = start(sampler, schedule)
    for first in range(0, schedule.steps, 50):
        state, _ = steps(state, np.arange(first, first + 50, dtype=np.uint32))
    after = variation({**params, **state.average}, ARCH, latents, seed=1, materials=16)
    # Sampling a GGX conductor by its visible normals leaves the weight F G1(wo), nearly constant.
    assert np.median(after) < 0.3
    assert np.median(after) < 0.5 * np.median(before)


def test_variation_is_that_of_a_known_integrand(overfitted, monkeypatch):
    # A Lambertian f, and a proposal of the cosine lobe and one other: cv agrees with quadrature.
    params, _, _ = overfitted
    weights, alphas = jnp.array([0.5, 0.0, 0.5]), jnp.array([0.5, 0.5])
    wi = jnp.array([[0.6, 0.0, 0.8]])
    monkeypatch.setattr(sampling, "propose", lambda *_: (weights, alphas))
    monkeypatch.setattr(
        sampling, "incoming_directions", lambda u, widths: jnp.broadcast_to(wi, (len(u), 3))
    )
    monkeypatch.setattr(sampling, "mean_f_cos", lambda p, arch, z, wi, wo: wo[..., 2] / jnp.pi)
    latents = jnp.zeros((2, ARCH.latent))
    cv = variation(params, ARCH, latents, seed=0, materials=4)
    # The reference: the second moment of f cos / p under p is the integral of (f cos)^2 / p.
    cosine, phi = np.meshgrid(
        (np.arange(800) + 0.5) / 800, (np.arange(800) + 0.5) / 800 * 2 * np.pi
    )
    sine = np.sqrt(1 - cosine**2)
    wo = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], -1)
    p = np.asarray(mixture_pdf(weights, alphas, wi, jnp.asarray(wo, jnp.float32)))
    second = ((wo[..., 2] / np.pi) ** 2 / p).mean() * 2 * np.pi
    np.testing.assert_allclose(cv, np.sqrt(second - 1), rtol=0.1)  # of 4,096 samples
