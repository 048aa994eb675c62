"""What tests of plugins share: textures of texels, f of a BSDF, scenes, and the walk in Python."""

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core.direction_sets import cosine_pairs
from urushi.core.directions import rotated
from urushi.mitsuba.reading import probing
from urushi.walk import Stack, simulate


def bitmap(pixels: np.ndarray, **properties) -> dict:
    """A texture of texels (H, W, C), of numbers as they are."""
    texels = mi.Bitmap(np.asarray(pixels, np.float32))
    return {"type": "bitmap", "bitmap": texels, "raw": True, **properties}


def strip(*texels, **properties) -> dict:
    """A texture of one row of texels, numbers or colours."""
    return bitmap(np.float32(texels).reshape(1, len(texels), -1), **properties)


def nearly(value: float, channels: int = 1) -> dict:
    """A texture that differs by less than codes resolve: one of one value would be a constant."""
    texels = np.full((2, 2, channels), value, np.float32)
    texels[0, 0] *= 1 + 1e-6
    return bitmap(texels)


def vector(w: np.ndarray) -> "mi.Vector3f":
    """Vectors (N, 3)."""
    return mi.Vector3f(np.ascontiguousarray(w.T))


def on_all_sides(wi: np.ndarray, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs above the horizon, turned so that as many pass a surface as are reflected."""
    wi, wo = wi.copy(), wo.copy()
    wi[::2, 2] *= -1
    wo[::4, 2] *= -1
    wo[1::4, 2] *= -1
    return wi, wo


def f(bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, uv=(0.0, 0.0)) -> np.ndarray:
    """f (N, C) [1/sr] for pairs (N, 3), at one place of uv or at (N, 2)."""
    return probing.bsdf_values(bsdf, wi, wo, np.broadcast_to(np.float32(uv), (len(wi), 2)))


def interaction(wi: np.ndarray, uv=(0.5, 0.5)) -> "mi.SurfaceInteraction3f":
    """Seen from wi (N, 3) at uv, (2,) or (N, 2), each with random numbers of its own."""
    at = np.broadcast_to(uv, (len(wi), 2))
    si = probing.interaction(np.asarray(wi, np.float32), at, np.arange(len(wi)))
    si.t = 1.0
    return si


def evaluated(bsdf, wi, wo, uv=(0.5, 0.5), mode="Radiance") -> tuple[np.ndarray, np.ndarray]:
    """f (N, C) [1/sr] and density (N,) [1/sr] of pairs (N, 3) on any sides."""
    context, out = mi.BSDFContext(getattr(mi.TransportMode, mode)), vector(np.float32(wo))
    f_cos, density = bsdf.eval_pdf(context, interaction(wi, uv), out)
    return f_cos.numpy().T / np.abs(out.z.numpy())[:, None], density.numpy()


def walked(bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, walks: int) -> np.ndarray:
    """f (walks, N, C) [1/sr] for pairs (N, 3), each at a place and by a walk of its own."""
    wi, wo = (np.tile(w, (walks, 1)) for w in (wi, wo))
    found, _ = evaluated(bsdf, wi, wo, np.random.default_rng(0).random((len(wi), 2)))
    return found.reshape(walks, len(wi) // walks, -1).astype(np.float64)


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


def update(bsdf: "mi.Object", values: dict) -> None:
    """Give parameters other values."""
    parameters = mi.traverse(bsdf)
    for key, value in values.items():
        parameters[key] = value
    parameters.update()


def slopes(parameters, steps: dict[str, float], function) -> tuple[list[float], list[float]]:
    """Derivatives of a function by parameters, each by all of its numbers, and its differences.

    parameters: of `mi.traverse`, which carry gradients afterwards. steps: to both sides, by key.
    """

    def value(key, change) -> float:
        parameters.update({x: start[x] + (change if x == key else 0) for x in steps})
        return float(np.sum(function().numpy()))

    start = {key: type(parameters[key])(parameters[key]) for key in steps}  # copies
    differences = [(value(k, x) - value(k, -x)) / (2 * x) for k, x in steps.items()]
    for key in steps:
        parameters[key] = start[key] + 0
        dr.enable_grad(parameters[key])
    parameters.update()
    dr.backward(function())
    return [float(dr.grad(parameters[key]).numpy().sum()) for key in steps], differences


def spheres(*bsdfs, integrator: str = "path", size: int = 16, depth: int = 3, **parts) -> dict:
    """A scene of spheres in a row, below a sky and, unless `parts` has another, a lamp."""
    to_world = mi.ScalarTransform4f().look_at([0, -4, 1], [0, 0, 0], [0, 0, 1])
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}}
    row = {
        f"sphere{i}": {"type": "sphere", "center": [2 * i + 1 - len(bsdfs), 0, 0], "bsdf": bsdf}
        for i, bsdf in enumerate(bsdfs)
    }
    return {
        "type": "scene",
        "integrator": {"type": integrator, "max_depth": depth},
        "sky": {"type": "constant", "radiance": 0.5},
        "lamp": {"type": "point", "position": [1, -2, 3], "intensity": 8.0},
        "sensor": {"type": "perspective", "fov": 50, "to_world": to_world, "film": film},
        **row,
        **parts,
    }


def in_white_world(bsdf, aside: float = 2.5) -> np.ndarray:
    """Linear sRGB of a plane under even light, one number in grey, seen at 40 degrees or others.

    aside: distance of the camera from the normal, three units above the plane.
    """
    to_world = mi.ScalarTransform4f().look_at([0, aside, 3], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}}
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": {"type": "perspective", "fov": 15, "to_world": to_world, "film": film},
        "light": {"type": "constant"},
        "shape": {"type": "rectangle", "bsdf": bsdf},
    }
    return np.array(mi.render(mi.load_dict(scene), spp=1024)).mean(axis=(0, 1))[:3]


def check_walk(bsdf: "mi.BSDF", stack: Stack, degrees: float = 0.0, sides: bool = False) -> None:
    """Walks of a plugin have the means of `simulate` of a stack, whose tangent is turned.

    At 16 pairs; sides: of both sides, as radiance and as importance.
    """
    wi, wo = cosine_pairs(np.random.default_rng(4), 16, lowest_cosine=0.05)
    if sides:
        wi, wo = on_all_sides(wi, wo)
    count, cosine = 1 << 12, np.abs(wo[:, 2:])
    a, b = (np.repeat(rotated(w, degrees / 360), count, axis=0) for w in (wi, wo))
    si = probing.interaction(a, np.random.default_rng(0).random((len(a), 2)))  # walks of their own
    for mode in ("Radiance", "Importance")[: 1 + sides]:
        context = mi.BSDFContext(getattr(mi.TransportMode, mode))
        walked = bsdf.eval(context, si, vector(b)).numpy().reshape(3, len(wi), count)
        mean, error = walked.mean(axis=2).T, walked.std(axis=2).T / count**0.5
        options = {"walks": 1 << 13, "progress": False, "mode": mode.lower()}
        expected, se = (x * cosine for x in simulate(stack, wi, wo, **options))
        z = (mean - expected) / np.hypot(error, se)
        # 48 values, whose channels may be the same.
        assert np.abs(z).max() < 5 and (z**2).mean() < 2.5
        assert np.hypot(error, se).sum() < 0.1 * expected.sum()  # the comparison is sharp
