"""The coasts of the Earth as coarse polygons of (longitude, latitude) in degrees.

They are drawn for a small globe and are up to a few degrees wrong. Rings are filled by the even-odd
rule, so that a ring within another is water.
"""

import numpy as np

from gallery import noise

_RINGS = """
-17 15 -16 20 -13 27 -10 30 -6 35.5 0 36 10 37 11 34 15 32 20 31 22 33 29 31 32.5 31 34 27 37 21
  39 15.5 43 11.5 51 12 50 8 46 2.5 42 -1.5 39.5 -5 40.5 -11 40 -15 35 -20 35.5 -24 32.5 -27 30 -31
  26 -34 20 -35 18 -32 15 -26.5 12 -18 13.5 -12 12.5 -6 9 -1 9.5 4 5 6 -2 5 -8 4.5 -12.5 7.5 -15 11
49.5 -12 50.5 -16 47.5 -25 44 -25 43.5 -21 44.5 -16.5
-9 37 -9.3 43.5 -2 43.5 -1 46 -4.5 48.3 2 51 5 53 8 55 8 57 10.5 57.7 10.5 54.5 14 54 19 54.5 21 57
  24 59 30 60 23 60 21.5 62 25 65.5 22 65.8 17.5 61.5 18.5 60 16.5 57 14 55.5 11 59 6 58.2 5 61
  11 64.5 15 68.5 20 70 26 71 31 70 41 67 40 64.5 44 66.5 44 68.5 54 68.5 60 69 68 68.5 67 72 73 73
  73 68 75 72 80 73.5 87 75 104 77.5 113 74 127 73 140 72.5 150 71 160 69.8 170 70 180 69 190 66
  179 62.5 170 60 163 58 162 55 157 51 156 57 163 61 155 59.5 143 59 135 54.5 141 52 140 48 135 43.5
  130 42.5 127.5 39.5 129.5 36 126.5 34.5 126 37.5 125 39.5 121.5 39 121 40.8 118 39 119 37.3
  122.5 37 119.5 35 122 31 121 28 116.5 23 110 20.5 108 21.5 105.8 19 109 13 106.8 10.4 105 8.8
  104.8 10.4 101 13 99.5 10 103.5 1.5 101 3 98.3 8 98.5 14 97 17 94.5 16 94 18.5 91.5 22.5 87 21.5
  82 16.5 80 13.5 79.8 10.3 77.5 8 75 12 73 17 72.5 21 70 21 67 25 61.5 25.2 57 26.7 54.5 26.7
  50.5 30 48 30 50 26.5 51.5 25.5 52 24 56.3 26.2 56.5 24.3 60 22.3 57.5 19 52.5 16 45 12.8 43 13
  42.5 16.5 39 21.5 35 28 35 31.5 36 36.5 31 36.5 27.5 36.8 26.5 39.5 29 41 35 42 41.5 41.3 37 45
  39 47.2 35.5 46.5 33.5 44.6 33 46.2 30.5 46.4 28 43.5 28.5 41.3 26 40.8 23.5 40.3 24 38 22.5 36.6
  21 38.5 19.3 41.8 15 44.3 13.3 45.7 12.3 44.5 16 41.7 18.3 40 16.5 39.5 16 38 15.6 40 11 42.4
  8.7 44.3 4 43.4 3 42 0 40 0 38.7 -2 36.8 -5.5 36
47 45 51 47 53.5 45 53.5 40 54 37 49.5 37.5 49 41
-5.5 50 1.5 51.3 1.5 52.8 0 53.5 -2 56 -3.5 58.6 -6 57 -3 54 -5 52
-6 52.3 -10 51.7 -10 54.2 -6 55.2
-22 64 -18.5 63.4 -13.8 65 -16 66.5 -22.5 66.3 -24 65
130 31.5 131 34 136 35.7 140 39 141.5 41.2 142 39.5 140.8 35.7 136.5 34 132 33
140 42 141.5 45.3 145.3 43.3 143 42
120.2 23 121.5 25.2 121 22
95.5 5.5 100.5 2 104 -2 106 -5.8 102 -4 98.7 1.5
105.5 -6.5 114 -7.5 114 -8.6 106.5 -7.4
109.3 1.8 113 3.2 117 7 119 5 117.5 1 116 -3.8 110.3 -2.8
119.5 -5.4 119.8 0.5 125 1.5 121 -0.8 123 -4.8 121 -2.5
131 -0.8 135 -3.3 138 -1.7 145 -4.3 150.5 -10.5 146 -8.6 143 -9 138 -8.3 137 -5 133 -4
120.3 16 120.8 18.5 122.2 18.3 124 12.6 126.3 8 125.5 5.8 122.2 7 123.5 10 120.5 13.8
80 9.5 81.8 7.5 80.3 6
114 -22 113.5 -26 115.7 -32 115.3 -34.3 118 -35 124 -33.8 131 -31.5 135.5 -35 138 -33 138.5 -35.6
  140.5 -38 146.3 -39 150 -37.4 153.3 -29 153 -25 149 -20.5 146 -18.8 145.3 -15 142.5 -10.8
  141 -16.5 139.5 -17.6 135.5 -15 137 -12.2 132.5 -11.3 129.8 -14.8 126.5 -14 122.3 -18
144.7 -40.8 148.3 -41 147 -43.6
172.8 -34.5 175.5 -36.6 178.5 -37.7 175.2 -41.6 173.8 -39.3
172.7 -40.6 174.2 -41.6 170.8 -45.9 168.4 -46.6 166.5 -45.9
-168 65.7 -162 66.5 -166.5 68.3 -156.5 71.3 -141 69.7 -128 70.2 -115 68 -108 67.8 -95 67.5 -93 71.5
  -88 68.5 -82 69.5 -81.5 67 -87 64.5 -94 61 -94.5 58.8 -92.5 57 -85 55.3 -82.3 53 -80 51.3
  -78.7 52.5 -79 54.7 -76.6 56.5 -78 60 -77.5 62.5 -72 61.7 -69.5 59 -65 60 -62 57.5 -56 53 -60 50.2
  -66 50 -65 48.2 -64.5 46.3 -60 47 -63.5 44.6 -66 43.6 -70 43.7 -70 41.7 -74 40.5 -75.8 36.5
  -81.3 31 -80.3 26 -81.8 26 -82.7 29 -85 29.7 -89.5 30 -94 29.5 -97.3 27 -97.8 22.5 -94.5 18.2
  -91 18.7 -90.3 21 -87 21.4 -88.3 18 -88.5 15.8 -83.3 15 -83.7 11 -81 9 -77.5 8.6 -80 7.4 -85.7 10
  -87.6 13 -92.3 14.5 -95 16 -101 17.4 -105.5 20.3 -106 23 -109 26 -112.5 30 -114.8 31.7 -112 27.5
  -109.5 23 -112 25 -115 28 -117 32.5 -120.5 34.5 -124.3 40.3 -124 46 -123 49 -128 51 -131 55
  -136 58.5 -145 60.3 -151.5 59.3 -158 56.5 -163.5 54.8 -158 58.7 -165 61 -164 63.3 -161 64.5
-92 46.7 -88 48.8 -84.7 46.6
-87.8 42 -86.2 42 -85.3 45.5 -87.5 45
-45 60 -42 62.5 -40 65 -32 68 -22 70.5 -20 75 -12 81.5 -32 83.5 -60 82 -72 78.5 -67 76 -58 75.5
  -54 70 -53.5 66.5 -51 62.5
-64.5 63 -66 66.5 -61.5 66.8 -68 70 -80 73.7 -89 73 -85 70 -78 69.7 -73 68 -72 65 -77.5 64.5
  -71.5 62.5
-117 70 -105.5 69 -102 70 -106 73.3 -118 73
-62 82.5 -75 78.6 -80 76.3 -90 76.5 -88 80.3 -91 82 -75 83.1
-59.3 47.7 -55.6 51.6 -53 47.5 -55.5 46.9
-84.8 21.9 -80.5 23.1 -74.2 20.2 -77.5 19.9 -78 20.8
-74.4 18.5 -73 19.9 -68.4 18.6
-77.5 8.6 -75.5 10.7 -71.7 12.3 -71.5 10.8 -68 11 -62 10.6 -60 8.5 -57 6 -51.5 4.3 -50 0.5 -44 -2.6
  -39 -3 -35.2 -5.5 -35 -9 -38.5 -13 -39.2 -17.8 -41 -22 -45 -23.6 -48.6 -26 -48.8 -28.6 -53.5 -34
  -57 -34.6 -58.3 -34 -57 -36.5 -58 -38.2 -62.2 -39 -65 -41 -64 -42.6 -67.5 -46 -66 -48 -69 -51
  -68.4 -52.4 -65.3 -54.7 -69 -55.3 -74.5 -51 -75.5 -46.8 -73 -42 -73.5 -37 -71.5 -31 -70.2 -19
  -76 -14 -79.5 -8 -81.3 -5 -80 -3 -80.8 -1 -79 1.5 -77.3 4 -78 7.3
-180 -78 -150 -77 -130 -74 -100 -72 -75 -72 -60 -64 -62 -74 -35 -78 -15 -72 0 -70 30 -69 60 -67
  90 -66 115 -66.5 140 -66.5 165 -71 165 -78 180 -78 180 -91 -180 -91
"""


def rings() -> list[np.ndarray]:
    """The coasts, each an (N, 2) array of longitudes and latitudes [degrees]."""
    lines = _RINGS.strip().replace("\n  ", " ").splitlines()
    return [np.array(line.split(), float).reshape(-1, 2) for line in lines]


def land(rows: int, *, crinkle: float = 0.9) -> np.ndarray:
    """The fraction of land in each texel of a map, (rows, 2 rows) in steps of 1/4.

    The map is equirectangular: row 0 is at the north pole, column 0 at longitude 0, and columns go
    east.

    Args:
        rows: number of texels from pole to pole.
        crinkle: amplitude of the fractal noise that moves the straight coasts [degrees].
    """
    longitude, latitude = (x[..., None] for x in grid(rows))
    points = sphere(longitude[..., 0], latitude[..., 0]) * 14
    off_longitude, off_latitude = (
        crinkle * noise.fractal(points, 4, seed=seed, gain=0.6)[..., None] for seed in (1, 21)
    )
    quarter = 180 / rows / 4
    longitude = longitude + quarter * np.array([-1, 1, -1, 1])
    latitude = latitude + quarter * np.array([-1, -1, 1, 1])
    longitude = longitude + off_longitude / np.maximum(np.cos(np.radians(latitude)), 0.1)
    longitude = (longitude + 180) % 360 - 180
    latitude = latitude + off_latitude
    inside = np.zeros(longitude.shape, bool)
    for ring in rings():
        inside ^= _within(ring, longitude, latitude)
        if ring[:, 0].max() > 180:  # across the date line
            inside ^= _within(ring, longitude + 360, latitude)
    return inside.mean(axis=-1)


def grid(rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Longitudes in [0, 360) and latitudes of the texels' centres, (rows, 2 rows) each."""
    longitude = 180 / rows * (np.arange(2 * rows) + 0.5)
    latitude = 90 - 180 / rows * (np.arange(rows) + 0.5)
    longitude, latitude = np.meshgrid(longitude, latitude)
    return longitude, latitude


def sphere(longitude: np.ndarray, latitude: np.ndarray) -> np.ndarray:
    """Points of the unit sphere (..., 3), z to the north, +x at longitude 0 [degrees]."""
    longitude, latitude = np.radians(longitude), np.radians(latitude)
    across = np.cos(latitude)
    return np.stack(
        [across * np.cos(longitude), across * np.sin(longitude), np.sin(latitude)], axis=-1
    )


def _within(ring: np.ndarray, longitude: np.ndarray, latitude: np.ndarray) -> np.ndarray:
    """Whether points lie in a polygon: an odd number of its edges then lies east of them."""
    low, high = ring.min(axis=0), ring.max(axis=0)
    near = (longitude >= low[0]) & (longitude <= high[0])
    near &= (latitude >= low[1]) & (latitude <= high[1])
    x, y = longitude[near], latitude[near]
    odd = np.zeros(x.shape, bool)
    for (x0, y0), (x1, y1) in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        if y0 != y1:
            odd ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    result = np.zeros(longitude.shape, bool)
    result[near] = odd
    return result
