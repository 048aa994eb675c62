"""What tests of plugins share: textures of texels, f of a BSDF, scenes, and the walk in Python."""

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


def hemisphere(count: int, seed: int) -> np.ndarray:
    """Unit vectors (count, 3) above the horizon, a third of them grazing."""
    rng = np.random.default_rng(seed)
    w = rng.normal(size=(count, 3))
    w[::3, 2] *= 1e-2
    w[:, 2] = np.abs(w[:, 2])
    return (w / np.linalg.norm(w, axis=1, keepdims=True)).astype(np.float32)


def pairs(count: int = 4096) -> tuple[np.ndarray, np.ndarray]:
    """Pairs, half of them close to mirror directions."""
    wi, wo = hemisphere(count, 1), hemisphere(count, 2)
    noise = np.random.default_rng(3).normal(size=(count, 3)) * 0.01
    mirrored = wi * [-1, -1, 1] + noise
    mirrored[:, 2] = np.abs(mirrored[:, 2])
    wo[::2] = (mirrored / np.linalg.norm(mirrored, axis=1, keepdims=True))[::2]
    return wi, wo


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


def walked(bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, walks: int) -> np.ndarray:
    """f (walks, N, C) [1/sr] for pairs (N, 3), each at a place of its own and thus by its walk."""
    repeated = (np.tile(w, (walks, 1)).astype(np.float32) for w in (wi, wo))
    uv = np.random.default_rng(0).random((walks * len(wi), 2))
    return f(bsdf, *repeated, uv).reshape(walks, len(wi), -1).astype(np.float64)


def update(bsdf: "mi.Object", values: dict) -> None:
    """Give parameters other values."""
    parameters = mi.traverse(bsdf)
    for key, value in values.items():
        parameters[key] = value
    parameters.update()


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
