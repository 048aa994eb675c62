"""What tests of `openpbr` share: materials, directions, and a BSDF's values and samples."""

import mitsuba as mi
import numpy as np

from urushi.core.direction_sets import cosine_pairs
from urushi.mitsuba.reading import probing

WHITE = (1.0, 1.0, 1.0)


def loaded(**parameters) -> "mi.BSDF":
    """The plugin; tuples are colours."""
    given = {
        name: {"type": "rgb", "value": list(x)} if isinstance(x, tuple) else x
        for name, x in parameters.items()
    }
    return mi.load_dict({"type": "openpbr", **given})


def pairs(count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Directions (count, 3) of cosine density above the horizon."""
    return cosine_pairs(np.random.default_rng(seed), count, lowest_cosine=0.02)


def anywhere(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions (count, 3) on the sphere, none near the horizon."""
    w = np.random.default_rng(seed).normal(size=(2, 2 * count, 3))
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    return tuple(x[np.abs(x[:, 2]) > 0.1][:count] for x in w)


def toward(cosine: float, degrees: float | np.ndarray = 36.87) -> np.ndarray:
    """Directions (3,) or (N, 3) of a cosine to the normal and of azimuths."""
    sine, azimuth = (1 - cosine**2) ** 0.5, np.radians(degrees)
    parts = sine * np.cos(azimuth), sine * np.sin(azimuth), cosine
    return np.stack(np.broadcast_arrays(*parts), -1)


def interaction(wi: np.ndarray, uv=(0.5, 0.5)) -> "mi.SurfaceInteraction3f":
    """Seen from wi (N, 3) at uv, (2,) or (N, 2), each with random numbers of its own."""
    at = np.broadcast_to(uv, (len(wi), 2))
    si = probing.interaction(np.asarray(wi, np.float32), at, np.arange(len(wi)))
    si.t = 1.0
    return si


def evaluated(bsdf, wi, wo, uv=(0.5, 0.5), mode="Radiance") -> tuple[np.ndarray, np.ndarray]:
    """f (N, C) [1/sr] and density (N,) [1/sr] of pairs (N, 3) on any sides."""
    out = mi.Vector3f(np.ascontiguousarray(np.float32(wo).T))
    context = mi.BSDFContext(getattr(mi.TransportMode, mode))
    f_cos, density = bsdf.eval_pdf(context, interaction(wi, uv), out)
    return f_cos.numpy().T / np.abs(out.z.numpy())[:, None], density.numpy()


def values(bsdf, wi, wo, repeats: int = 1, **options) -> np.ndarray:
    """f (N, C) [1/sr], the mean over evaluations that draw other random numbers."""
    wi, wo = (np.tile(w, (repeats, 1)) for w in (wi, wo))
    return evaluated(bsdf, wi, wo, **options)[0].reshape(repeats, len(wi) // repeats, -1).mean(0)


def sampled(bsdf, wi, count: int, uv=(0.5, 0.5), mode="Importance"):
    """Weights (N, count, C) and directions (N, count, 3) of samples for light from wi (N, 3).

    uv: (2,) or (N, 2). The weights of importance are shares of power.
    """
    wi, index = np.repeat(np.atleast_2d(wi), count, 0), np.tile(np.arange(count), np.size(wi) // 3)
    u = [((index + 0.5) * 1.2207440846057596**-k % 1).astype(np.float32) for k in (1, 2, 3)]
    uv = np.repeat(uv, count, 0) if np.ndim(uv) > 1 else uv
    context = mi.BSDFContext(getattr(mi.TransportMode, mode))
    bs, weight = bsdf.sample(context, interaction(wi, uv), mi.Float(u[0]), mi.Point2f(u[1], u[2]))
    return tuple(np.float64(x.numpy()).T.reshape(-1, count, len(x)) for x in (weight, bs.wo))


def error(found: np.ndarray, expected: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> float:
    """Sum of the absolute deviations of f over the sum of f, by cosines."""
    weight = (wi[:, 2] * wo[:, 2])[:, None]
    return (np.abs(found - expected) * weight).sum() / (expected * weight).sum()
