"""Distributions of stacks for evaluation alone, beside those of `urushi.train.distribution`."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from urushi.checks import MIN_ALPHA, TRAINED_WIDTH_RATIO, Widths
from urushi.train.distribution import DRAW_ETA, Extended, draw_medium
from urushi.walk.bottoms import KINDS
from urushi.walk.bottoms.bottom import draw_alpha
from urushi.walk.table import StackTable

#: Share of anisotropic stacks whose coats all have equal widths, where the bottom has not.
ISOTROPIC_COATS = 0.3


@dataclass(frozen=True)
class Table2:
    """Fan et al. 2022, Table 2: rough dielectric coats over a conductor with Schlick's Fresnel.

    alpha = U(0.216, 1)^3, eta = U(1.05, 2), R0 = U(0, 1), albedo = 1 - U(0, 1)^2,
    sigma_t from {0, 1, 2, 5} with equal chances, g = 0.
    """

    # Dielectric interfaces, each with a medium below. The "two layers" of Fan et al. are one coat.
    coats: int = 1
    bottom: ClassVar[str] = "conductor"

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        """Draw n stacks."""
        shape = (n, self.coats)
        return StackTable(
            kind=self.bottom,
            alpha=rng.uniform(0.216, 1.0, shape) ** 3,
            eta=rng.uniform(1.05, 2.0, shape),
            albedo=1 - rng.uniform(0.0, 1.0, shape) ** 2,
            sigma_t=rng.choice([0.0, 1.0, 2.0, 5.0], shape),
            g=np.zeros(shape),
            bottom={"alpha": rng.uniform(0.216, 1.0, n) ** 3, "r0": rng.uniform(0.0, 1.0, n)},
        )


@dataclass(frozen=True)
class Clear(Extended):
    """`Extended` with clear or optically thin media, such as varnish.

    sigma_t = max(0, U(-0.3, 0.3)). No medium blurs the lobes of the interfaces, so that these
    stacks are the hardest to predict.
    """

    def sample(self, rng: np.random.Generator, n: int) -> StackTable:
        table = super().sample(rng, n)
        table.sigma_t[:] = np.maximum(rng.uniform(-0.3, 0.3, table.sigma_t.shape), 0.0)
        return table


def anisotropic(rng: np.random.Generator, n: int, coats: int, kind: str) -> StackTable:
    """n stacks of `Extended` with two widths of every coat, and of bottoms of a kind of two widths.

    The widths have the geometric mean of `Extended` and a quotient that is log-uniform in
    [1/8, 8]; for a fifth of the surfaces it is one. Of the stacks whose bottom has two widths, the
    share `ISOTROPIC_COATS` has coats of one width only.
    """
    shape, own = (n, coats), KINDS[kind]
    alpha = _draw_widths(rng, draw_alpha(rng, shape))
    if own.widths == 2:
        plain = rng.random((n, 1)) < ISOTROPIC_COATS
        alpha = Widths(alpha.u, np.where(plain, alpha.u, alpha.v))
    rng.random(shape)  # stored references were drawn after them
    eta = DRAW_ETA["common"](rng, shape)
    medium = draw_medium(rng, shape)
    columns = own.family.draw(rng, n, DRAW_ETA["common"])
    for name in [name for name in columns if name not in own.parameters]:
        widths = _draw_widths(rng, columns.pop(name))
        columns |= {f"{name}_u": widths.u, f"{name}_v": widths.v}
    bottom = {name: columns[name] for name in own.parameters}
    return StackTable(alpha, eta, *medium, kind, bottom)


def _draw_widths(rng: np.random.Generator, mean: np.ndarray) -> Widths:
    """Two widths in [0.01, 1] of this geometric mean, see `anisotropic`."""
    limit = np.log(TRAINED_WIDTH_RATIO)
    quotient = np.exp(rng.uniform(-limit, limit, np.shape(mean)))
    quotient = np.where(rng.random(np.shape(mean)) < 0.2, 1.0, quotient)
    root = np.sqrt(quotient)
    return Widths(np.clip(mean * root, MIN_ALPHA, 1.0), np.clip(mean / root, MIN_ALPHA, 1.0))
