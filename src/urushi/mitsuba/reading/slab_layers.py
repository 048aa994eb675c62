"""The layers of a slab, of which some parameters vary over a surface or carry gradients."""

from collections.abc import Mapping, Sequence

import mitsuba as mi
import numpy as np
import numpy.typing as npt

from urushi.checks import MIN_ALPHA
from urushi.core.namespace import NUMPY
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading.grid import varying_textures
from urushi.mitsuba.reading.parameters import CoatTextures
from urushi.mitsuba.reading.ranges import range_of
from urushi.mitsuba.reading.varying import (
    CHANGES,
    COAT,
    RANGES,
    agree,
    joined,
    of_coat,
    parameter_along,
)
from urushi.mitsuba.reading.wavelengths import (
    WAVELENGTH,
    WAVELENGTHS,
    along_u,
    wavelengths_varying,
)
from urushi.mitsuba.snapshot import has_gradients
from urushi.textures.axes import REFLECTANCE, WIDTH, Axis, Changes, Leader, Varying

#: Difference of channels that are the same up to rounding.
ALIKE = 1e-5

#: Ranges of widths, and of the rows of media.
WIDTHS = MIN_ALPHA, 1.0
MEDIUM = {"albedo": (0.0, 1.0), "sigma_t": (0.0, np.inf), "g": (-0.999, 0.999)}


class SlabLayers:
    """The layers of a slab as functions of the parameters that vary.

    Attributes:
        axes: the parameters along axes.
        constants: those that carry gradients and do not vary.
    """

    def __init__(
        self,
        coats: Sequence[CoatTextures],
        lowest: Mapping[str, "mi.Texture"] | None,
        beyond: tuple[float, float],
    ):
        """Read the parameters.

        coats: from top to bottom, of one width and one index each.
        lowest: the texture of the width of the last interface, if it has one; None: the width is
            that of the last coat.
        beyond: alpha and eta of the last interface.
        """
        parts = [(x, level) for level, coat in enumerate(coats) for x in _of_coat(coat)]
        parts += [(x, len(coats)) for x in _of_interface(lowest or {})]
        wavelength, coloured = _of_wavelength(coats)
        every = joined([_of_level(*part) for part in parts]) + coloured
        names = [(x.axis.name, x.axis.name.split()) for x in every]
        self._places = {name: (int(level), field) for name, (level, field) in names}
        self.axes = [x for x in every if not (x.changes or x.leader)] + wavelength
        self.led = [x for x in every if x.leader]
        self.constants = [x for x in every if x.changes]
        self._coloured = [(x.axis, x.leader) for x in coloured if x.leader]
        rows = [coat.layering(spectrum.MIDDLE) for coat in coats]
        channels = max(x.size for row in rows for x in row[2:])
        self._media = np.array(
            [[np.broadcast_to(x.ravel(), channels) for x in row[2:]] for row in rows]
        )
        self._interfaces = np.array([*((*row.alpha.flat, *row.eta.flat) for row in rows), beyond])
        self._shared = lowest is None
        for x in every:
            if not x.changes:  # any number
                self._set(self._interfaces, self._media, x.axis.name, 0.5)
        if (self._media == self._media[..., :1]).all():
            self._media = self._media[..., :1]

    @property
    def changes(self) -> list[Changes]:
        """Those of the constants, of the channel of the largest value."""
        return [x.changes for x in self.constants if x.changes]

    def share(self, constant: Varying) -> np.ndarray:
        """Changes of a constant in each channel relative to the largest one, (C,) or (1,)."""
        part, least = CHANGES[constant.axis.scale]
        values = self._row(self._interfaces, self._media, constant.axis.name)
        return (part * values + least) / (part * values.max() + least)

    def at(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The interfaces (n + 1, 2) and the media (n, 3, C) of `slab_tables`.

        numbers: values along the axes, and then changes of the constants.
        """
        layers = self._interfaces.copy(), self._media.copy()
        given = {x.axis.name: number for x, number in zip(self.axes, numbers, strict=False)}
        for x in self.led:
            if x.leader is not None:
                given[x.axis.name] = float(x.leader.at(given[x.leader.name]))
        given.pop(WAVELENGTH, None)
        for name, value in given.items():
            self._set(*layers, name, value)
        for x, change in zip(self.constants, numbers[len(self.axes) :], strict=True):
            now = self._row(*layers, x.axis.name)
            self._set(*layers, x.axis.name, now + change * self.share(x))
        return layers

    def apart(self, x: np.ndarray) -> np.ndarray:
        """Coordinates (n, d') by whose distances slabs differ, of those (n, d) along the axes.

        In place of the wavelength they have those of all constants that follow it: where the
        spectrum of a constant returns to a value, the slab may return to what it was.
        """
        columns = [*x.T]
        if self._coloured:
            place = columns.pop()
            columns += [axis.coordinate(led.at(place), NUMPY) for axis, led in self._coloured]
        return np.stack(columns, axis=1) if columns else x

    def lie_within(self, other: "SlabLayers") -> bool:
        """Whether these layers are among those along the axes of others."""
        pairs = zip(self.axes, other.axes, strict=False)
        spectra = ([led.own for _, led in layers._coloured] for layers in (self, other))
        return (
            [*self._places] == [*other._places]
            and [x.differentiable for x in self.axes] == [x.differentiable for x in other.axes]
            and all(b.axis.contains(a.axis) for a, b in pairs)
            and all(map(agree, other.led, self.led))
            and all(map(np.array_equal, *spectra))
            and not (self.constants or other.constants)
            and np.array_equal(self._interfaces, other._interfaces)
            and np.array_equal(self._media, other._media)
        )

    def _row(self, interfaces: np.ndarray, media: np.ndarray, name: str) -> np.ndarray:
        """The numbers of a parameter: one, or of a medium one for each channel."""
        level, field = self._places[name]
        if field in MEDIUM:
            return media[level, [*MEDIUM].index(field)]
        return interfaces[level, :1]

    def _set(
        self,
        interfaces: np.ndarray,
        media: np.ndarray,
        name: str,
        value: npt.ArrayLike,
    ) -> None:
        level, field = self._places[name]
        self._row(interfaces, media, name)[:] = np.clip(value, *MEDIUM.get(field, WIDTHS))
        if field not in MEDIUM and self._shared and level == len(interfaces) - 2:
            interfaces[-1, 0] = interfaces[level, 0]


def _of_level(parameter: Varying, level: int) -> Varying:
    """A parameter with a name of its own, and the scale of tables."""
    axis = parameter.axis
    # Lobes move through a table by the logarithm of their width.
    scale = REFLECTANCE if axis.scale == WIDTH else axis.scale
    return parameter._replace(axis=axis._replace(name=f"{level} {axis.name}", scale=scale))


def _of_coat(coat: CoatTextures) -> list[Varying]:
    """The parameters of a coat that vary or carry gradients, without its index.

    In spectral variants, a coloured constant that carries a gradient varies, too.
    """
    found = {x.axis.name: x for x in of_coat(coat, [n for n in coat.names if n != "eta"])}
    for name, own in found.items() if mi.is_spectral else ():
        if own.changes and name in MEDIUM:
            with spectrum.reading_at(spectrum.FINE):
                values = spectrum.channels_at(spectrum.MIDDLE, own.read)
            if np.ptp(values) > ALIKE:
                axis = own.axis._replace(least=values.min(), most=values.max(), own=True)
                found[name] = own._replace(axis=axis, changes=None)
    return [*found.values()]


def _of_wavelength(coats: Sequence[CoatTextures]) -> tuple[list[Varying], list[Varying]]:
    """The wavelength, if constants are coloured in a spectral variant, and these constants.

    They follow the wavelength, along whose axis all of them together change evenly.
    """
    found = []
    nm = np.linspace(*spectrum.ENDS, WAVELENGTHS + 1)
    for level, coat in enumerate(coats if mi.is_spectral else ()):
        known = [x.axis.name for x in of_coat(coat, [*MEDIUM])]
        with spectrum.reading_at(nm.astype(np.float32)):
            rows = coat.numbers(along_u(len(nm)))
        for name in MEDIUM:
            (row,) = rows[name]
            if name not in known and np.ptp(row) > ALIKE:
                axis = Axis(name, COAT[name][0], float(row.min()), float(row.max()), own=True)
                found.append((level, axis, row))
    if not found:
        return [], []
    changes = sum(np.abs(np.diff(axis.coordinate(row, NUMPY))) for _, axis, row in found)
    along = wavelengths_varying(nm, changes)
    assert along.places is not None  # for the type checker
    led = [(level, axis, Leader(WAVELENGTH, along.places[0], row)) for level, axis, row in found]
    return [along], [_of_level(Varying(x, along.read, leader=y), level) for level, x, y in led]


def _of_interface(textures: Mapping[str, "mi.Texture"]) -> list[Varying]:
    """The width of a last interface that has one of its own, if it varies or carries a gradient."""
    found = []
    for name, texture in textures.items():

        def read(si, active, texture=texture) -> list:
            return [texture.eval_1(si, active)]

        least, most = range_of(read, [texture], RANGES[WIDTH], True)
        axis, gradient = Axis(name, WIDTH, least, min(most, 1.0)), has_gradients(texture)
        if gradient or varying_textures(texture):
            found += parameter_along(axis, RANGES[WIDTH] if gradient else None, read, [texture])
    return found
