"""The chi-squared test of a BSDF's sampling, on a domain that resolves narrow lobes."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from mitsuba.python.chi2 import ChiSquareTest

#: Power of the map below: a larger one gives denser cells around the mirror direction.
CROWDING = 4


class MirrorDomain:
    """The hemisphere by azimuth and polar angle, with dense cells around a mirror direction.

    A GGX lobe of width 0.01 would lie in a single cell of a uniform grid. Here x in [-1, 1] gives
    the azimuth pi sign(x) |x|^p from the plane of incidence. y gives the polar angle by the same
    power on either side of the mirror direction, so that the horizon is a border of cells.
    """

    def __init__(self, theta_i: float):
        self.theta_i = theta_i

    def bounds(self):
        return mi.ScalarBoundingBox2f([-1, -1], [1, 1])

    def aspect(self):
        return 1

    def map_forward(self, p):
        sin_phi, cos_phi = dr.sincos(dr.pi * dr.sign(p.x) * dr.abs(p.x) ** CROWDING)
        shift = dr.sign(p.y) * self._room(p.y > 0) * dr.abs(p.y) ** CROWDING
        sin, cos = dr.sincos(self.theta_i + shift)
        return mi.Vector3f(-sin * cos_phi, -sin * sin_phi, cos)

    def map_backward(self, w):
        phi = dr.atan2(-w.y, -w.x) / dr.pi
        theta = dr.atan2(dr.hypot(w.x, w.y), w.z)
        room = self._room(theta > self.theta_i)
        shift = dr.clip((theta - self.theta_i) / dr.maximum(room, 1e-9), -1, 1)
        return mi.Vector2f(*(dr.sign(x) * dr.abs(x) ** (1 / CROWDING) for x in (phi, shift)))

    def jacobian(self, w):
        """Solid angle per area of the domain."""
        x, y = self.map_backward(w)
        slope_x, slope_y = (CROWDING * dr.abs(v) ** (CROWDING - 1) for v in (x, y))
        return dr.hypot(w.x, w.y) * dr.pi * slope_x * self._room(y > 0) * slope_y

    def _room(self, above):
        return dr.select(above, 0.5 * dr.pi - self.theta_i, self.theta_i)


class SphereDomain:
    """Two hemispheres side by side: about the mirror direction, and, from x = 1 on, about that of
    straight light on the other side."""

    def __init__(self, theta_i, eta: float):
        """theta_i: to the upper normal; eta: index below relative to that above."""
        cosine, sine = dr.cos(theta_i), dr.sin(theta_i)
        self._above = cosine > 0
        straight = sine * dr.select(self._above, 1 / eta, eta)
        self._near = MirrorDomain(dr.select(self._above, theta_i, dr.pi - theta_i))
        self._far = MirrorDomain(dr.asin(dr.minimum(straight, 0.95)))

    def bounds(self):
        return mi.ScalarBoundingBox2f([-1, -1], [3, 1])

    def aspect(self):
        return 0.5

    def map_forward(self, p):
        near, far = self._near.map_forward(p), self._far.map_forward(p - mi.Vector2f(2, 0))
        return self._turned(dr.select(p.x < 1, near, far * mi.Vector3f(1, 1, -1)))

    def map_backward(self, w):
        w = self._turned(w)
        near = self._near.map_backward(w)
        far = self._far.map_backward(w * mi.Vector3f(1, 1, -1)) + mi.Vector2f(2, 0)
        near.x = dr.minimum(near.x, 1 - 1e-6)  # rounding would reach the other hemisphere
        return dr.select(w.z > 0, near, far)

    def jacobian(self, w):
        """Solid angle per area of the domain."""
        w = self._turned(w)
        far = self._far.jacobian(w * mi.Vector3f(1, 1, -1))
        return dr.select(w.z > 0, self._near.jacobian(w), far)

    def _turned(self, w):
        return mi.Vector3f(w.x, w.y, dr.select(self._above, w.z, -w.z))


def chi_squared(bsdf, degrees: float, seed: int = 0, eta: float | None = None) -> ChiSquareTest:
    """The test of `bsdf.sample` against `bsdf.pdf` for wi at an angle from the normal.

    eta: index below a slab relative to that above; None: the BSDF is opaque.
    """
    theta = mi.Float(np.radians(degrees))
    dr.make_opaque(theta)  # one kernel for all directions
    wi = mi.Vector3f(dr.sin(theta), 0, dr.cos(theta))
    domain = MirrorDomain(theta) if eta is None else SphereDomain(theta, eta)
    context = mi.BSDFContext()

    def interaction(count):
        si = dr.zeros(mi.SurfaceInteraction3f, count)
        si.wi = wi
        return si

    def sample(u):
        bs, _ = bsdf.sample(context, interaction(dr.width(u)), u[0], mi.Point2f(u[1], u[2]))
        return bs.wo, dr.select(bs.pdf > 0, mi.Float(1), 0)

    def pdf(wo):
        return bsdf.pdf(context, interaction(dr.width(wo)), wo) * domain.jacobian(wo)

    return ChiSquareTest(
        domain,
        sample,
        pdf,
        sample_dim=3,
        sample_count=1 << 17,
        res=41,
        ires=12,
        seed=seed,
    )


def check(bsdf, angles, cases: int, eta: float | None = None) -> None:
    """The test at 1 % for the angles of all `cases` together; no sample fails.

    The density's integral is one: 0.5 % is the error of the quadrature, of which narrow lobes have
    a few points.
    """
    for seed, degrees in enumerate(angles):
        test = chi_squared(bsdf, degrees, seed, eta)
        assert test.run(0.01, test_count=cases * len(angles), quiet=True), (degrees, test.messages)
        assert test.pdf_sum[0] == pytest.approx(1, abs=0.005)
        assert test.histogram_sum[0] == 1
