"""Conversions between quantities of other shaders and OpenPBR's."""

import numpy as np

from urushi.core import fresnel
from urushi.core.namespace import NUMPY


def mix(bg: np.ndarray | float, fg: np.ndarray | float, t: np.ndarray) -> np.ndarray:
    return bg * (1 - t) + fg * t


def peak(colour: np.ndarray) -> np.ndarray:
    """The largest channel (..., 1)."""
    return colour.max(-1, keepdims=True)


def unit(colour: np.ndarray) -> np.ndarray:
    """A colour with a largest channel of 1; black stays."""
    largest = peak(colour)
    return colour / np.where(largest > 0, largest, 1)


def roughness_of(tangent: np.ndarray, bitangent: np.ndarray) -> np.ndarray:
    """OpenPBR's roughness of two GGX widths: r^4 is the mean of their squares."""
    return np.minimum(((tangent**2 + bitangent**2) / 2) ** 0.25, 1)


def stretched(roughness: np.ndarray, anisotropy: np.ndarray) -> np.ndarray:
    """OpenPBR's roughness for MaterialX's node `roughness_anisotropy`.

    It has the widths r^2 / s and r^2 s with s^2 = 1 - a; OpenPBR's have the same ratio.
    """
    aspect = np.sqrt(1 - np.clip(anisotropy, 0, 0.98))
    return roughness_of(roughness**2 / aspect, roughness**2 * aspect)


def edge_tint(reflectivity: np.ndarray, edge_color: np.ndarray) -> np.ndarray:
    """The specular_color with which OpenPBR's metal has the reflectance of `artistic_ior` at F82.

    Gulbrandsen, Artist Friendly Metallic Fresnel, JCGT 3(4), 2014, equations 6 to 8.

    Args:
        reflectivity, edge_color: (..., 3) in [0, 1].
    """
    r, g = np.clip(reflectivity, 0, 0.99), np.clip(edge_color, 0, 1)
    n = mix((1 + np.sqrt(r)) / (1 - np.sqrt(r)), (1 - r) / (1 + r), g)
    k = np.sqrt(np.maximum(((n + 1) ** 2 * r - (n - 1) ** 2) / (1 - r), 0))
    c = fresnel.EDGE_COSINE
    return np.minimum(fresnel.exact(c, n, k, NUMPY) / fresnel.schlick(c, r, NUMPY), 1)


def ior_of(f0: np.ndarray) -> np.ndarray:
    """The index of refraction of a reflectance at normal incidence."""
    root = np.sqrt(np.clip(f0, 0, 0.9))
    return (1 + root) / (1 - root)


def f0_of(ior: np.ndarray) -> np.ndarray:
    """The reflectance of an index of refraction at normal incidence, above 0."""
    return np.maximum(((ior - 1) / (ior + 1)) ** 2, 1e-6)
