"""The frame of a material's tangent as shader code: rotation of directions into it and back.

The networks take directions in a frame whose x axis is the tangent. `Tangent` holds the tangent of
a rotated material in the frame of the caller's directions.
"""

from typing import NamedTuple

import numpy as np

from urushi.export.expressions import FLOAT, Expression, expression, vector
from urushi.export.statements import Function, Variable

#: Fields of an anisotropic material: components of its tangent, of length one.
FIELDS = (
    Variable("tangent_x", FLOAT, note="the tangent in the frame of wi and wo, a unit vector:"),
    Variable("tangent_y", FLOAT, note="the cosine and the sine of the material's rotation"),
)


class Tangent(NamedTuple):
    """The tangent (x, y, 0) of a material, of length one."""

    x: Expression
    y: Expression

    @classmethod
    def of(cls, rotation: float) -> "Tangent":
        """That of a known rotation [degrees]."""
        angle = np.radians(rotation)
        return cls(expression(float(np.cos(angle))), expression(float(np.sin(angle))))

    @property
    def _is_x_axis(self) -> bool:
        return self.x.constant is not None and self.x.constant == 1.0

    def inside(self, body: Function, w: Expression, label: str) -> Expression:
        """A direction in the frame of the tangent; itself if that is the x axis."""
        if self._is_x_axis:
            return w
        turned = vector(w.x * self.x + w.y * self.y, w.y * self.x - w.x * self.y, w.z)
        return body.let(label, turned)

    def outside(self, body: Function, w: Expression, label: str) -> Expression:
        """A direction of the tangent's frame in the caller's."""
        if self._is_x_axis:
            return w
        turned = vector(w.x * self.x - w.y * self.y, w.x * self.y + w.y * self.x, w.z)
        return body.let(label, turned)


#: That of a material that is not turned.
X_AXIS = Tangent.of(0.0)
