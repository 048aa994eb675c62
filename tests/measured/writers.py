"""Measured files for the tests, by writers independent of the readers; headers can be forged."""

import struct

import numpy as np
from tests.oracles import surfaces

from urushi.core.directions import directions_at

TYPES = {"u1": 1, "i1": 2, "u2": 3, "i2": 4, "u4": 5, "i4": 6, "u8": 7, "i8": 8, "f2": 9}
TYPES |= {"f4": 10, "f8": 11}

#: Diffuse reflectance of `plastic`.
COLOUR = np.array([0.9, 0.5, 0.2])

MERL_SCALE = np.array([1.0, 1.15, 1.66]) / 1500.0


def merl_directions():
    """wi, wo (1458000, 3) at the bin centres of a MERL table; z < 0 below the horizon."""
    theta_h = ((np.arange(90) + 0.5) / 90) ** 2 * np.pi / 2
    theta_d = (np.arange(90) + 0.5) * np.pi / 180
    phi_d = (np.arange(180) + 0.5) * np.pi / 180
    angles = (a.ravel() for a in np.meshgrid(theta_h, theta_d, phi_d, indexing="ij"))
    return directions_at(*angles)


def plastic(wi, wo, alpha=0.3):
    """A diffuse base under a GGX lobe with Schlick's Fresnel term, independent of Urushi's own."""
    lobe = surfaces.bottom("conductor", wi, wo, alpha, 0.04)
    return COLOUR / np.pi + lobe[:, None]


def write_merl(path, rgb):
    """Write rgb (bins, 3) [1/sr] as a MERL file."""
    with path.open("wb") as file:
        np.array([90, 90, 180], "<i4").tofile(file)
        (rgb / MERL_SCALE).T.astype("<f8").tofile(file)
    return path


def tensor_file(fields, *, forge=None):
    """The bytes of a tensor file with the given arrays.

    forge: maps names to false (shape, type code, offset) in the header; None is the true value.
    """
    header = b"tensor_file\0\1\0" + struct.pack("<I", len(fields))
    claimed = {name: (forge or {}).get(name, (None, None, None)) for name in fields}
    ranks = [len(claimed[name][0] or np.shape(array)) for name, array in fields.items()]
    start = len(header) + sum(
        13 + len(name.encode()) + 8 * rank for name, rank in zip(fields, ranks, strict=True)
    )
    data = b""
    for name, array in fields.items():
        array = np.asarray(array)
        truth = (array.shape, TYPES[array.dtype.str[1:]], start + len(data))
        shape, code, offset = (
            fact if claim is None else claim
            for claim, fact in zip(claimed[name], truth, strict=True)
        )
        encoded = name.encode()
        header += struct.pack("<H", len(encoded)) + encoded
        header += struct.pack("<HBQ", len(shape), code, offset)
        header += struct.pack(f"<{len(shape)}Q", *shape)
        data += array.tobytes()
    return header + data


def rgl_tensors(phi_i, theta_i, ndf, sigma, vndf, colour, wavelengths):
    """The tensors of a material; colour is RGB without wavelengths."""
    floats = {"phi_i": phi_i, "theta_i": theta_i, "ndf": ndf, "sigma": sigma, "vndf": vndf}
    floats |= {"luminance": np.ones_like(vndf), "rgb": colour}
    if wavelengths is not None:
        floats |= {"wavelengths": wavelengths, "spectra": floats.pop("rgb")}
    numbers = {"description": np.frombuffer(b"made up", np.uint8), "jacobian": np.ones(1, np.uint8)}
    return {name: np.asarray(array, np.float32) for name, array in floats.items()} | numbers


def rgl_fields(rng, *, wavelengths=None, size=8, elevations=4, azimuths=None):
    """The tensors of a small, smooth, made-up material; isotropic, or measured at azimuths (P,)."""
    smooth = np.linspace(0.5, 1.5, size, dtype=np.float32)
    channels = 3 if wavelengths is None else len(wavelengths)
    phi_i = np.zeros(1) if azimuths is None else np.asarray(azimuths)
    count = len(phi_i)
    colour = rng.uniform(0.1, 1, (count, elevations, channels, size, size))
    # Rows are azimuths: those of one azimuth do not differ.
    turn = np.ones((2, 1)) if count == 1 else rng.uniform(0.5, 1.5, (size, 1))
    theta_i = np.linspace(0, np.pi / 2, elevations, dtype=np.float32)
    vndf = rng.uniform(0.1, 1, (count, elevations, size, size))
    areas = turn * smooth[::-1], turn[::-1] * smooth
    return rgl_tensors(phi_i, theta_i, *areas, vndf, colour, wavelengths)


def rgl_ggx_fields(alpha, r0, *, wavelengths=None, elevations=48, size=97):
    """The tensors of a GGX conductor with Schlick's reflectances r0 (channels,).

    `vndf` is uniform, so that its warp is the identity. With sigma = cos_i / G1(wi), the format
    stores F(wi.m) G1(wo).
    """
    node, theta_i = np.linspace(0, 1, size), np.linspace(0, np.pi / 2, elevations)
    theta_m, phi_m = node**2 * np.pi / 2, (2 * node[:, None] - 1) * np.pi

    def g1(cosine):
        stretched = np.sqrt(alpha**2 * (1 - cosine**2) + cosine**2)
        return 2 * np.abs(cosine) / (np.abs(cosine) + stretched)

    cos_m, cos_i = np.cos(theta_m), np.cos(theta_i)[:, None, None]
    cos_d = np.sin(theta_i)[:, None, None] * np.sin(theta_m) * np.cos(phi_m) + cos_i * cos_m
    cos_o = 2 * cos_d * cos_m - cos_i  # (elevation of wi, azimuth of m, elevation of m)
    r0 = np.reshape(r0, (-1, 1, 1, 1))
    fresnel = r0 + (1 - r0) * (1 - np.maximum(cos_d, 0)) ** 5
    colour = np.swapaxes(fresnel * g1(cos_o), 0, 1)[None]
    ndf = 1 / (np.pi * (alpha * ((1 - cos_m**2) / alpha**2 + cos_m**2)) ** 2)
    above = np.maximum(cos_m, 1e-4)
    areas = (np.tile(x, (2, 1)) for x in (ndf, above / g1(above)))  # rows are azimuths
    flat = np.ones((1, elevations, 2, 2))
    return rgl_tensors(np.zeros(1), theta_i, *areas, flat, colour, wavelengths)
