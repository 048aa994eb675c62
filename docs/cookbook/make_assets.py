"""Makes the shapes and textures of the cookbook: python docs/cookbook/make_assets.py

The results in `stage/` are stored beside the scenes, so that a scene loads without this script.
Textures are computed where the surface is: a texel has the value of a solid pattern at its point.
"""

from pathlib import Path

import numpy as np

STAGE = Path(__file__).parent / "stage"

#: Control points (radius, height) of uniform cubic B-splines, from the foot's centre to the axis.
VASE = [
    (0.0, 0.0),
    (0.30, 0.0),
    (0.42, 0.01),
    (0.46, 0.08),
    (0.48, 0.20),
    (0.66, 0.55),
    (0.86, 0.95),
    (0.90, 1.35),
    (0.72, 1.68),
    (0.38, 1.86),
    (0.27, 2.02),
    (0.30, 2.16),
    (0.46, 2.24),
    (0.47, 2.28),
    (0.43, 2.29),
    (0.26, 2.18),
    (0.20, 1.95),
    (0.20, 1.7),
    (0.10, 1.6),
    (0.0, 1.6),
]
STAND = [
    (0.0, 0.0),
    (0.40, 0.0),
    (0.66, 0.0),
    (0.70, 0.03),
    (0.66, 0.07),
    (0.50, 0.10),
    (0.44, 0.16),
    (0.46, 0.24),
    (0.50, 0.29),
    (0.46, 0.31),
    (0.30, 0.27),
    (0.12, 0.25),
    (0.0, 0.25),
]


def main() -> None:
    STAGE.mkdir(exist_ok=True)
    for name, control, rows in [("vase", VASE, 81), ("stand", STAND, 41)]:
        write_ply(STAGE / f"{name}.ply", *lathe(outline(control, rows), 65))
    write_textures()


def outline(control: list[tuple[float, float]], count: int) -> np.ndarray:
    """Points (count, 2) at equal distances along the spline, which starts and ends on the axis."""
    points = np.array(control)
    mirror = np.array([-1.0, 1.0])
    points = np.vstack([points[1] * mirror, points, points[-2] * mirror])
    t = np.linspace(0, len(control) - 1, 4096)
    first = np.minimum(t.astype(int), len(control) - 2)
    s = (t - first)[:, None]
    weights = [(1 - s) ** 3, 3 * s**3 - 6 * s**2 + 4, -3 * s**3 + 3 * s**2 + 3 * s + 1, s**3]
    dense = sum(w * points[first + k] for k, w in enumerate(weights)) / 6
    length = np.append(0, np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1)))
    at = np.linspace(0, length[-1], count)
    result = np.stack([np.interp(at, length, column) for column in dense.T], axis=1)
    result[[0, -1], 0] = 1e-4  # nearly closed: no triangle degenerates
    return result


def lathe(points: np.ndarray, columns: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions (N, 3), uv (N, 2) and quads (M, 4) of an outline turned about the z axis."""
    rows = len(points)
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    turn = 2 * np.pi * u
    positions = np.stack(
        [points[:, :1] * np.cos(turn), points[:, :1] * np.sin(turn), points[:, 1:] + 0 * u], axis=-1
    )
    index = np.arange(rows * columns).reshape(rows, columns)
    quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], axis=-1)
    return positions.reshape(-1, 3), np.stack([u, v], -1).reshape(-1, 2), quads.reshape(-1, 4)


def write_ply(path: Path, positions: np.ndarray, uv: np.ndarray, quads: np.ndarray) -> None:
    """Write a binary PLY file with smooth normals, which closed seams need."""
    normals = smooth_normals(positions, quads)
    names = ("x", "y", "z", "nx", "ny", "nz", "u", "v")
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(positions)}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {2 * len(quads)}", "property list uchar int vertex_index"]
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("vertex", "<i4", 3)])
    faces["count"], faces["vertex"] = 3, triangles
    data = np.hstack([positions, normals, uv]).astype("<f4")
    path.write_bytes(
        "\n".join([*header, "end_header\n"]).encode() + data.tobytes() + faces.tobytes()
    )


def smooth_normals(positions: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Unit normals (N, 3); vertices at one point, as on the seam, share theirs."""
    a, b, c, d = (positions[quads[:, k]] for k in range(4))
    of_faces = np.cross(c - a, d - b)
    _, same = np.unique(np.round(positions, 5), axis=0, return_inverse=True)
    sums = np.zeros((same.max() + 1, 3))
    np.add.at(sums, same.ravel()[quads], of_faces[:, None, :])
    sums /= np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-12)
    return sums[same.ravel()]


def texels(control: list[tuple[float, float]], width: int, height: int) -> np.ndarray:
    """Points (height, width, 3) of a turned surface at a texture's texels; v is 0 in row 0."""
    points = outline(control, 4 * height)
    rows = points[np.clip(((np.arange(height) + 0.5) * 4).astype(int), 0, len(points) - 1)]
    turn = 2 * np.pi * (np.arange(width) + 0.5) / width
    radius, z = rows[:, :1], rows[:, 1:]
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z + 0 * turn], axis=-1)


def noise(points: np.ndarray, seed: int = 0) -> np.ndarray:
    """Smooth value noise in [-1, 1] with cells of size 1 at points (..., 3)."""
    cell = np.floor(points).astype(np.int64)
    s = points - cell
    s = s * s * (3 - 2 * s)
    result = np.zeros(points.shape[:-1])
    for corner in np.ndindex(2, 2, 2):
        x, y, z = np.moveaxis(cell + corner, -1, 0)
        h = (x * 73856093 ^ y * 19349663 ^ z * 83492791 ^ seed * 2654435761) & 0xFFFFFFFF
        for _ in range(2):
            h = (h ^ h >> 16) * 0x45D9F3B & 0xFFFFFFFF
        share = np.prod(np.where(corner, s, 1 - s), axis=-1)
        result += share * ((h ^ h >> 16) / 2**31 - 1)
    return result


def fractal(points: np.ndarray, octaves: int, seed: int = 0) -> np.ndarray:
    """Noise of several octaves, each with half the amplitude and size of the one before."""
    return sum(0.5**k * noise(points * 2**k, seed + k) for k in range(octaves))


def smoothstep(a: float, b: float, x: np.ndarray) -> np.ndarray:
    t = np.clip((x - a) / (b - a), 0, 1)
    return t * t * (3 - 2 * t)


def mix(a, b, t: np.ndarray) -> np.ndarray:
    """Colours (..., 3) between a and b."""
    return np.asarray(a) + (np.asarray(b) - np.asarray(a)) * t[..., None]


def wood() -> np.ndarray:
    """Reflectance of walnut, cut from a log whose axis leans: rings, pores and rays."""
    p = texels(VASE, 512, 512)
    bend = 0.22 * fractal(p * [1.1, 1.1, 0.45], 3, 5)[..., None] * [1, 1, 0]
    x, y, z = np.moveaxis(p + bend, -1, 0)
    radius = np.hypot(x + 1.7 + 0.22 * z, y - 0.5 + 0.1 * z)
    ring = radius * 6.5 + 0.25 * fractal(p * 2, 2, 9)
    phase = ring - np.floor(ring)
    late = smoothstep(0.35, 0.95, phase) * smoothstep(1.0, 0.96, phase)
    fibre = fractal(np.stack([x * 22, y * 22, z * 1.6], -1), 3, 17)
    pores = smoothstep(0.25, 0.55, noise(np.stack([x * 55, y * 55, z * 4], -1), 23)) * (1 - late)
    tone = np.clip(0.55 * late + 0.18 * fibre + 0.12 * noise(p * 0.9, 31) + 0.18, 0, 1)
    colour = mix([0.42, 0.215, 0.09], [0.13, 0.052, 0.02], tone)
    return colour * (1 - 0.45 * pores[..., None])


def waves(size: int = 256) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Seigaiha, waves of concentric arcs (H, W): share of wire, number of the arc, place in it."""
    fine = 3 * size
    x, y = np.meshgrid((np.arange(fine) + 0.5) / fine, (np.arange(fine) + 0.5) / fine)
    found = np.full(x.shape, np.inf)
    # Scales overlap downwards: the lowest centre whose disc covers the point is in front.
    for row in range(6, -7, -1):
        centre_y = row * 0.25
        for column in range(-2, 4):
            centre_x = column * 1.0 + (0.5 if row % 2 else 0)
            r = np.hypot(x - centre_x, (y - centre_y) * 1.0) / 0.5
            free = np.isinf(found) & (r <= 1)
            found[free] = r[free]
    bands = found * 4
    near = np.abs(bands - np.round(bands))
    wire = ((near < 0.075) & (np.round(bands) >= 1)).astype(float)
    arc = np.floor(bands + 1e-9)

    def down(a: np.ndarray) -> np.ndarray:
        return a.reshape(size, 3, size, 3).mean(axis=(1, 3))

    return down(wire)[::-1], down(arc)[::-1], down(bands - arc)[::-1]


def glaze_depth() -> np.ndarray:
    """Optical depth of a glaze that has run down and stands in drops above the foot."""
    p = texels(VASE, 256, 256)
    x, y, z = np.moveaxis(p, -1, 0)
    turn = np.stack([np.cos(np.arctan2(y, x)), np.sin(np.arctan2(y, x)), 0 * z], -1)
    edge = 0.92 - 0.62 * np.hypot(noise(turn * 3.3, 3), 0.12)
    above = z - edge
    roll = np.exp(-(((above - 0.05) / 0.05) ** 2))
    run = smoothstep(-0.01, 0.03, above) * (0.85 + 1.9 * np.exp(-np.maximum(above, 0) / 0.45))
    streaks = 1 + 0.35 * fractal(np.concatenate([turn[..., :2] * 7, p[..., 2:] * 0.9], -1), 3, 8)
    lip = 1 - 0.75 * smoothstep(2.05, 2.25, z)
    return 0.12 + (run * streaks + 2.2 * roll) * lip


def worn() -> np.ndarray:
    """Thickness of a lacquer that is rubbed off at lip, shoulder and foot, and in patches."""
    p = texels(VASE, 512, 512)
    edges = sum(
        weight * np.exp(-(((p[..., 2] - z) / width) ** 2))
        for z, width, weight in ((2.26, 0.07, 1.2), (1.35, 0.16, 0.75), (0.05, 0.1, 1.1))
    )
    patches = fractal(p * [3.5, 3.5, 5.0], 5, 41)
    return 1 - 0.97 * smoothstep(0.45, 0.75, 0.85 * edges + 0.55 * patches)


def flakes(size: int = 256) -> np.ndarray:
    """Reflectance of metal flakes: tiles of different brightness, without a seam."""
    rng = np.random.default_rng(4)
    centres = rng.random((2600, 2))
    x, y = np.meshgrid((np.arange(size) + 0.5) / size, (np.arange(size) + 0.5) / size)
    best, which = np.full(x.shape, np.inf), np.zeros(x.shape, int)
    for k, (a, b) in enumerate(centres):
        dx, dy = np.abs(x - a), np.abs(y - b)
        d = np.minimum(dx, 1 - dx) ** 2 + np.minimum(dy, 1 - dy) ** 2
        nearer = d < best
        best[nearer], which[nearer] = d[nearer], k
    return (0.35 + 0.65 * rng.random(len(centres)) ** 1.6)[which]


def ginkgo(width: int = 1024, height: int = 512) -> np.ndarray:
    """Share of gold: fallen ginkgo leaves, with veins, and gold dust that thins out upwards."""
    p = texels(VASE, width, height)
    radius, z = np.hypot(p[..., 0], p[..., 1]), p[..., 2]
    turn = 2 * np.pi * (np.arange(width) + 0.5) / width + 0 * z
    rows = (np.arange(height)[:, None] + 0.5) / height
    outside = rows < 0.74  # not the inside of the neck
    rng = np.random.default_rng(11)
    gold = np.zeros((height, width))
    for _ in range(34):
        # Coordinates about the leaf, in units of length on the surface
        at, up, size = rng.random() * 2 * np.pi, rng.uniform(0.18, 1.62), rng.uniform(0.17, 0.30)
        tilt = rng.uniform(0, 2 * np.pi)
        dx = (np.remainder(turn - at + np.pi, 2 * np.pi) - np.pi) * radius / size
        dy = (z - up) / size
        a, b = np.cos(tilt) * dx + np.sin(tilt) * dy, -np.sin(tilt) * dx + np.cos(tilt) * dy
        r, angle = np.hypot(a, b), np.arctan2(a, b)
        rim = 1 + 0.05 * np.cos(9 * angle) - 0.42 * np.exp(-((angle / 0.10) ** 2))
        blade = smoothstep(1.02, 0.97, r / rim) * smoothstep(1.12, 1.06, np.abs(angle))
        veins = 1 - 0.75 * smoothstep(0.55, 0.9, np.cos(26 * angle)) * smoothstep(0.12, 0.4, r)
        stem = smoothstep(0.05, 0.025, np.abs(a - 0.15 * b**2)) * (b < 0.1) * (b > -0.75)
        leaf = np.maximum(blade * veins, stem)
        gold = np.where(blade + stem > 0.02, np.maximum(leaf, gold * (1 - blade - stem)), gold)
    dust = (rng.random((height, width)) < 0.30 * np.exp(-((z / 0.55) ** 2))) * rng.random(z.shape)
    collar = smoothstep(0.015, 0.009, np.abs(z - 1.93)) + smoothstep(0.02, 0.012, np.abs(z - 1.885))
    return np.clip(np.maximum.reduce([gold, dust, collar]), 0, 1) * outside


def write_textures() -> None:
    import mitsuba as mi

    mi.set_variant("scalar_rgb")

    def write(name: str, values: np.ndarray) -> None:
        bitmap = mi.Bitmap(np.atleast_3d(values).astype(np.float32))
        if name.endswith(".exr"):
            bitmap = bitmap.convert(component_format=mi.Struct.Type.Float16)
        else:
            raw = not name.endswith(".jpg")
            bitmap.set_srgb_gamma(False)
            bitmap = bitmap.convert(component_format=mi.Struct.Type.UInt8, srgb_gamma=not raw)
        bitmap.write(str(STAGE / name), quality=82 if name.endswith(".jpg") else -1)

    write("wood.jpg", wood())
    wire, arc, slope = waves()
    cells = np.array(
        [[0.05, 0.14, 0.60], [0.06, 0.46, 0.74], [0.60, 0.90, 0.90], [0.975, 0.975, 0.95]]
    )
    index = np.clip(arc, 0, 3)
    low = np.floor(index).astype(int)
    colour = mix(0, 1, index - low) * (cells[np.minimum(low + 1, 3)] - cells[low]) + cells[low]
    write("waves-albedo.exr", colour)
    write("waves-depth.exr", 8 * (1 - wire))
    write("carved.png", 0.1 + 0.9 * slope**2)
    write("glaze-depth.exr", glaze_depth())
    write("worn.png", worn())
    write("flakes.png", flakes())
    write("ginkgo.png", ginkgo())


if __name__ == "__main__":
    main()
