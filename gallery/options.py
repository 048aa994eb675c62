"""Options of the scenes; importing them needs no Mitsuba."""

from dataclasses import dataclass
from typing import Annotated, Any, Literal, get_args

from urushi import ranges
from urushi.errors import ParameterError
from urushi.ranges import Pixels, Range, Samples

#: `nets.weights.DEFAULT`; importing that takes seconds.
DEFAULT_WEIGHTS = "default"

#: The plugins for the coats of a scene; the first one uses networks, the second one walks.
Coat = Literal["neural_layered", "layered"]
COATS: tuple[Coat, ...] = get_args(Coat)


@dataclass(frozen=True)
class Options:
    """Options of a scene.

    Attributes:
        coat: plugin of all coats, those of OpenPBR included: the networks, or the walk.
        weights: networks of neural_layered: default, or a weights file.
        width: width of the picture in pixels.
        height: height of the picture in pixels.
        spp: samples per pixel.
        detail: factor on the width and height of every texture, above 0 and at most 4; with less
            detail the scene loads faster.
    """

    coat: Coat = COATS[0]
    weights: str = DEFAULT_WEIGHTS
    width: Pixels = 640
    height: Pixels = 480
    spp: Samples = 64
    detail: Annotated[float, Range(0, 4, above=True)] = 1.0

    def check(self) -> None:
        """Raise ParameterError if the plugin is unknown or a number is out of range."""
        if self.coat not in COATS:
            raise ParameterError(f"coat is '{self.coat}'; choose one of {', '.join(COATS)}")
        ranges.check(self, "")

    def texels(self, count: int) -> int:
        """Number of texels along a side that has `count` texels at detail 1."""
        return max(8, round(count * self.detail))

    def coated(self, bottom: dict[str, Any], **parameters: Any) -> dict[str, Any]:
        """The coat with these parameters over `bottom`.

        `weights` are left out if they are the default, so that the scenes of networks and reference
        differ in one word.
        """
        return {"type": self.coat, **parameters, **self._weights(), "bottom": bottom}

    def openpbr(self, **parameters: Any) -> dict[str, Any]:
        """The material of these parameters of OpenPBR, its coat by the plugin `coat`."""
        return {"type": "openpbr", "reference": self.coat, **parameters, **self._weights()}

    def _weights(self) -> dict[str, str]:
        named = self.coat == COATS[0] and self.weights != DEFAULT_WEIGHTS
        return {"weights": self.weights} if named else {}
