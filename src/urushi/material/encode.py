"""`urushi.encode`: materials of descriptions, stacks, measured and other BRDFs."""

from typing import Any

from urushi.material.layer import encoded, warn_of
from urushi.material.material import Material
from urushi.material.source import source_name
from urushi.nets.weights import Weights


def encode(source: Any, weights: Weights | None = None, *, table: bool | None = None) -> Material:
    """Encode a BRDF into latent codes, one per channel.

    Args:
        source: a description (conductor, dielectric, diffuse), a Stack (by light transport), a
            Material, a measured BRDF, a Mitsuba BSDF, or a callable or an object with a method f:
            f(wi, wo) -> (N, 3), (N, C), or (N,) for one channel [1/sr, no cosine]. It is evaluated
            at pairs above the horizon only. An anisotropic source keeps its anisotropy about the
            tangent, the x axis. A source that is not reciprocal, or not symmetric about the
            tangent, is averaged to have these symmetries (see `urushi.material.symmetry`). Of a
            BSDF that transmits, only the reflection is encoded.
        weights: a Model or a weights file. None: the shipped ones, "anisotropic" for
            anisotropic sources. Those of isotropic materials encode the average of an
            anisotropic source over the azimuth.
        table: whether the material also gets a table of f over directions (see
            `urushi.core.table`), which is used to evaluate and render it. A code may differ by
            10 % and more from f of several narrow lobes, a table by 0.2 %. Textures use the
            codes. The source is evaluated at 25,000 more pairs and their mirror images, or at 124
            rotations of each if it is not symmetric; a file is 150 kB larger. None: for all sources
            of one width but conductors without energy compensation, dielectrics and Lambertians,
            whose codes are exact, and Mitsuba BSDFs and Stacks that only random walks know. Give
            False for a slow function, and for one that draws random numbers. A bare conductor or
            dielectric, and a Material of the same weights, get none.

    Raises:
        ParameterError: the source is none of these; it is an anisotropic Stack, but the weights
            are isotropic; its values have a wrong shape, are negative or not finite; or it is a
            BSDF without rough reflection.
        FileError: the shipped weights are missing.

    Warns:
        UrushiWarning: averaging changes the source by more than 10 %, or transmitted or specular
            light is left out.
    """
    material, deviations = encoded(source, weights, table)
    warn_of(deviations, f"encode {source_name(source)}")
    return material
