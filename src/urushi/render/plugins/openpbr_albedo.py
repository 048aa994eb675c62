"""The albedos of `openpbr_surface.interface_albedo` as Dr.Jit textures, and what they give back."""

from collections.abc import Callable

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.openpbr_surface import interface_albedo as tables


class InterfaceAlbedo:
    """Directional albedos of a rough dielectric interface, from above.

    eta: its index if it is constant; None: any between 1/3 and 3.
    """

    def __init__(self, eta: float | None):
        self._constant = eta is not None
        known = tables.tables(None if eta is None else float(np.clip(eta, 1 / 3, 3)))
        self._reflected = self._texture(known.reflected)
        self._reflected_mean = self._texture(known.reflected_mean)
        self._both = self._texture(known.reflected, known.passed)
        self._both_mean = self._texture(known.reflected_mean, known.passed_mean)

    def reflected(self, cosine, alpha, eta):
        """Share of the light from a direction that is reflected."""
        return _read(self._reflected, self._at(cosine, alpha, eta))[0]

    def both(self, cosine, alpha, eta) -> list:
        """Shares that are reflected and transmitted; the rest would meet a second facet."""
        return _read(self._both, self._at(cosine, alpha, eta))

    def reflected_mean(self, alpha, eta):
        """Share of diffuse light that is reflected."""
        return _read(self._reflected_mean, self._at(None, alpha, eta))[0]

    def both_mean(self, alpha, eta) -> list:
        """Shares of diffuse light that are reflected and transmitted."""
        return _read(self._both_mean, self._at(None, alpha, eta))

    def _texture(self, *values: np.ndarray):
        """Tables as channels, without the axis of the index if it is constant."""
        table = np.stack(values, axis=-1)
        return _texture(table[0] if self._constant else table)

    def _at(self, cosine, alpha, eta) -> list:
        """Coordinates in [0, 1] of a look-up, the last axis of the tables first."""
        at = [] if cosine is None else [dr.safe_sqrt(cosine)]
        index = [] if self._constant else [tables.index_coordinate(eta, dr)]
        return [*at, tables.roughness_coordinate(alpha, dr), *index]


class MirrorAlbedo:
    """Directional albedos of GGX facets that reflect all light."""

    def __init__(self) -> None:
        known = tables.mirror_tables()
        self._albedo, self._mean = (_texture(x[..., None]) for x in (known.albedo, known.mean))

    def lost(self, seen_i, seen_o, alpha, fresnel_mean):
        """The lobe [1/sr] of light that meets more than one facet.

        seen_i, seen_o: `seen` of both directions. fresnel_mean: cosine-weighted mean of the
        facets' Fresnel term.

        Source: Kulla and Conty 2017, with the Fresnel term of Jimenez and Hanika in their notes.
        """
        mean = self.seen_mean(alpha)
        color = self.multiple(fresnel_mean, alpha)
        # Where nothing is lost, the quotient is 0 / 0.
        return color * ((1 - seen_i) * (1 - seen_o) / dr.maximum(dr.pi * (1 - mean), 1e-6))

    def seen(self, cosine, alpha):
        """Share of the light from a direction that one reflection by the facets lets leave."""
        return _read(self._albedo, [dr.safe_sqrt(cosine), tables.roughness_coordinate(alpha, dr)])[
            0
        ]

    def seen_mean(self, alpha):
        """The cosine-weighted mean of `seen` over the hemisphere."""
        return _read(self._mean, [tables.roughness_coordinate(alpha, dr)])[0]

    def multiple(self, fresnel_mean, alpha):
        """The albedo of light that facets of a mean Fresnel term reflect more than once.

        Source: as of `lost`.
        """
        mean = self.seen_mean(alpha)
        return fresnel_mean * fresnel_mean * mean / (1 - fresnel_mean * (1 - mean))

    def gain(self, alpha, f0):
        """The factor by which multiple scattering increases a lobe of reflectance f0.

        Source: Turquin 2019, Practical multiple scattering compensation for microfacet models,
        with the mean albedo in place of the directional one.
        """
        mean = self.seen_mean(alpha)
        return 1 + f0 * ((1 - mean) / mean)


def interpolated(table: np.ndarray) -> Callable[[list], list]:
    """A table of channels, the last axis, as a function of coordinates in [0, 1].

    The coordinate of the last axis but the channels comes first.
    """
    texture = _texture(table)
    return lambda at: _read(texture, at)


def _texture(table: np.ndarray):
    """A table as a texture, whose last axis are channels, linear between the nodes."""
    kinds = {2: mi.Texture1f, 3: mi.Texture2f, 4: mi.Texture3f}
    return kinds[table.ndim](
        mi.TensorXf(np.ascontiguousarray(table)),
        use_accel=False,
        filter_mode=dr.FilterMode.Linear,
        wrap_mode=dr.WrapMode.Clamp,
    )


def _read(texture, at: list) -> list:
    """The channels at coordinates in [0, 1], from the first to the last node of each axis."""
    sizes = reversed(texture.shape[:-1])
    position = [(x * (size - 1) + 0.5) / size for x, size in zip(at, sizes, strict=True)]
    kinds = {1: mi.Point1f, 2: mi.Point2f, 3: mi.Point3f}
    return list(texture.eval(kinds[len(at)](*position)))
