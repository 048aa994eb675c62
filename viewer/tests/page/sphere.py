"""The pixels that the example with three.js must show: `sphere.py FOLDER SIZE`.

Writes the exported material into the folder. Prints JSON: a list of pixels of a square picture of
SIZE pixels per side, with `place` (column and row), and `lights` and `sky`, the reflected radiances
in linear light. The lights are summed by `Material.f`, the sky is integrated by a product rule.
"""

import json
import sys
from pathlib import Path

import numpy as np

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
sys.path.insert(0, str(EXAMPLES))

from material import lacquer, main  # noqa: E402

LIGHTS = np.array([[1, 2, 2], [-3, 1, 1], [2, -1, 0.5]])
IRRADIANCES = np.array([[1.2, 1.2, 1.2], [0.3, 0.4, 0.7], [0.8, 0.5, 0.3]])
DISTANCE, ANGLE = 4, np.radians(35)

#: The silhouette is left out, where the triangles of the sphere show.
LEAST_COSINE = 0.2


def unit(v: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) of length one."""
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def hit(column: int, row: int, size: int) -> tuple[np.ndarray, np.ndarray] | None:
    """The normal where the ray of a pixel meets the unit sphere, and the direction to the eye."""
    x, y = (2 * column + 1) / size - 1, 1 - (2 * row + 1) / size
    ray = unit(np.array([x * np.tan(ANGLE / 2), y * np.tan(ANGLE / 2), -1]))
    eye = np.array([0, 0, DISTANCE])
    b = eye @ ray
    root = b * b - DISTANCE**2 + 1
    if root < 0:
        return None
    return eye + ray * (-b - np.sqrt(root)), -ray


def frame(z: np.ndarray) -> np.ndarray:
    """A rotation (3, 3) whose last row is z."""
    x = unit(np.cross(z, (0.36, 0.48, 0.8)))
    return np.stack([x, np.cross(z, x), z])


def sky(direction: np.ndarray) -> np.ndarray:
    """The radiance (N, 3) from directions (N, 3)."""
    t = np.clip((direction[:, 1:2] + 0.3) / 0.8, 0, 1)
    t = t * t * (3 - 2 * t)
    return (1 - t) * (0.15, 0.12, 0.1) + t * np.array([0.5, 0.65, 0.9])


def hemisphere() -> tuple[np.ndarray, np.ndarray]:
    """Directions (N, 3) and weights (N,) of an integral over solid angle."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    z, count = (nodes + 1) / 2, 128
    angle = 2 * np.pi * np.arange(count) / count
    r = np.sqrt(1 - z * z)[:, None]
    height = np.broadcast_to(z[:, None], (64, count))
    directions = np.stack([r * np.cos(angle), r * np.sin(angle), height], -1)
    return directions.reshape(-1, 3), np.repeat(weights / 2 * 2 * np.pi / count, count)


def pixels(size: int) -> list[dict[str, list[float]]]:
    """What the picture shows at pixels of a grid."""
    material = lacquer()
    wo, weights = hemisphere()
    step, result = size // 12, []
    for row in range(step // 2, size, step):
        for column in range(step // 2, size, step):
            met = hit(column, row, size)
            if met is None or met[0] @ met[1] < LEAST_COSINE:
                continue
            local = frame(met[0])
            to = unit(LIGHTS) @ local.T
            all_wo = np.concatenate([to, wo])
            f = material.f(np.tile(local @ met[1], (len(all_wo), 1)), all_wo)
            lit = f[: len(to)] * np.maximum(to[:, 2:], 0) * IRRADIANCES
            scattered = f[len(to) :] * (wo[:, 2] * weights)[:, None] * sky(wo @ local)
            result.append(
                {
                    "place": [column, row],
                    "lights": lit.sum(axis=0).tolist(),
                    "sky": scattered.sum(axis=0).tolist(),
                }
            )
    return result


if __name__ == "__main__":
    main(Path(sys.argv[1]))
    print(json.dumps(pixels(int(sys.argv[2]))))
