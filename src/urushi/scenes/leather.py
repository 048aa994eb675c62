"""Leather: grain, creases, seams and stitches, as heights, and the patina that goes with them."""

import numpy as np

from urushi.scenes import noise, shoe_shape
from urushi.scenes.mesh import derivatives, normal_map

#: The seam around the toe and the strap over the instep, in v; lengths are the shoe's own.
APRON, STRAP = 0.50, (0.70, 0.90)


def upper(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The upper at texels u (1, W) and v (H, 1).

    Returns:
        Albedo and optical depth of the finish, (H, W, 3) each, and the leather's height (H, W).
    """
    points = shoe_shape.upper(u, v)
    toe = 0.5 - np.abs(u - 0.5) + 0 * v  # 0.5 at the toe, 0 at the heel
    grain = _grain(points)
    worn = noise.fractal(points * 1.7, 4, seed=5)

    apron = APRON + 0.30 * noise.smoothstep(0.40, 0.24, toe)  # it climbs towards the instep
    ridge = np.exp(-(((v - apron) / 0.016) ** 2)) * noise.smoothstep(0.22, 0.26, toe)
    pleats = 0.5 + 0.5 * np.cos(2 * np.pi * 150 * u)
    strap = noise.smoothstep(STRAP[0] - 0.006, STRAP[0] + 0.006, v + 0 * u)
    strap *= noise.smoothstep(STRAP[1] + 0.006, STRAP[1] - 0.006, v + 0 * u)
    strap *= noise.smoothstep(0.215, 0.225, toe)
    window = (np.abs(u - 0.5) < 0.035) & (np.abs(v - 0.80) < 0.035)
    stitches = _stitches(u, v, 0.955) + _stitches(u, v, 0.045)
    stitches += (strap > 0.5) * (
        _stitches(u, v, STRAP[0] + 0.018) + _stitches(u, v, STRAP[1] - 0.018)
    )
    flex = noise.smoothstep(0.35, 0.0, np.abs(points[..., 0] - 0.55) * 2) * (v > 0.3)
    creases = flex * noise.fractal(points * [9, 1.5, 5], 3, seed=9)

    height = 0.0022 * grain + 0.012 * creases + 0.032 * ridge * (0.6 + 0.4 * pleats)
    height += 0.034 * strap * (1 - window) + 0.006 * stitches

    # Polish gathers in folds and at the ends of the shoe: there it is dark and deep.
    burnt = noise.smoothstep(0.30, 0.49, toe) * (1 - 0.5 * v) + noise.smoothstep(0.10, 0.0, toe)
    burnt = np.clip(burnt * 0.85 + 0.25 * worn + 0.35 * noise.smoothstep(0.10, 0.0, v), 0, 1)
    folds = np.clip(0.5 * (1 - grain) + 0.9 * ridge * (1 - pleats) + 1.0 * window, 0, 1)
    light, dark = np.array([0.86, 0.42, 0.15]), np.array([0.42, 0.10, 0.04])
    albedo = light + (dark - light) * burnt[..., None]
    thread = stitches[..., None]
    albedo = albedo * (1 - 0.25 * folds[..., None])
    albedo = albedo + (np.array([0.95, 0.85, 0.62]) - albedo) * thread
    depth = np.array([0.35, 0.6, 0.9]) * (1 + 2.6 * burnt[..., None] + 0.8 * folds[..., None])
    return albedo, depth * (1 + thread), height


def relief(points: np.ndarray, height: np.ndarray) -> np.ndarray:
    """The normal map of heights on a surface, given by its points at the texels."""
    along_u, along_v = (np.linalg.norm(d, axis=-1) for d in derivatives(points))
    return normal_map(height, np.maximum(along_u, 0.2), np.maximum(along_v, 0.2), closed=True)


def _grain(points: np.ndarray) -> np.ndarray:
    """Pebbles of leather: 0 in the furrows between them, 1 on them."""
    bent = points + 0.02 * noise.fractal(points * 8, 2, seed=2)[..., None]
    first, second = noise.cells(bent * 24, seed=4)
    return noise.smoothstep(0.0, 0.35, second - first)


def _stitches(u: np.ndarray, v: np.ndarray, line: float) -> np.ndarray:
    """A dashed line along u at v = line."""
    dash = noise.smoothstep(-0.2, 0.3, np.cos(2 * np.pi * 170 * u))
    return dash * np.exp(-(((v - line) / 0.006) ** 4))
