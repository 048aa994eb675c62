"""The random walk over surfaces of two widths: reciprocity, symmetries, and equal widths."""

import dataclasses

import numpy as np
import pytest
from tests.directions import pairs_above
from tests.walk.test_walk import random_table

from urushi.checks import Widths
from urushi.walk import (
    Stack,
    coat,
    conductor,
    dielectric,
    diffuse,
    simulate,
    walk_pairs,
)
from urushi.walk.monte_carlo import backend

#: Anisotropic at the top, at the bottom, at both, and with three interfaces; per channel once.
STACKS = {
    "top": coat(diffuse(0.8), None, 1.5, 0.9, 0.5, 0.3, alpha_u=0.5, alpha_v=0.1),
    "bottom": coat(conductor(r0=0.9, alpha_u=0.08, alpha_v=0.5), 0.15, 1.4, 0.8, 0.7),
    "both": coat(
        conductor(eta=(0.2, 0.9, 1.5), k=(3.9, 2.4, 1.9), alpha_u=0.4, alpha_v=(0.1, 0.2, 0.3)),
        *(None, 1.6),
        alpha_u=0.1,
        alpha_v=0.6,
    ),
    "three": coat(
        coat(dielectric(eta=1.8, alpha_u=0.2, alpha_v=0.6), 0.3, 1.2, 0.9, 0.5),
        *(None, 0.8, 0.9, 0.3, -0.5),
        alpha_u=0.7,
        alpha_v=0.2,
    ),
}


def check_equal_means(a: tuple[np.ndarray, ...], b: tuple[np.ndarray, ...]) -> None:
    """Two independent estimates (f, se) agree."""
    # Rounding of the analytic top reflection is allowed.
    z = (a[0] - b[0]) / np.sqrt(a[1] ** 2 + b[1] ** 2 + (1e-5 * a[0]) ** 2)
    # 300 values of long-tailed estimates, channels in part the same: z is wider than a Gaussian.
    assert np.abs(z).max() < 6
    assert abs(z.mean()) < 4 / np.sqrt(len(z))
    assert np.mean(z**2) < 1.6
    # The comparison is sharp enough to see the anisotropy.
    assert np.median(a[1] / a[0]) < 0.05


def run(stack: Stack, wi: np.ndarray, wo: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    f, se = simulate(stack, wi, wo, walks=1 << 12, seed=seed, progress=False)
    return f.astype(np.float64), se.astype(np.float64)


@pytest.mark.parametrize("stack", STACKS.values(), ids=STACKS.keys())
def test_stacks_are_reciprocal_in_the_mean(stack: Stack) -> None:
    wi, wo = pairs_above(100, 1, 0.1)
    check_equal_means(run(stack, wi, wo, 1), run(stack, wo, wi, 2))


@pytest.mark.parametrize(
    ("name", "signs"),
    [("top", (-1, -1, 1)), ("bottom", (1, -1, 1)), ("both", (-1, 1, 1)), ("three", (1, -1, 1))],
)
def test_stacks_have_the_symmetries_of_their_tangent(name: str, signs: tuple[int, ...]) -> None:
    """A half turn, and mirrors at both axes."""
    stack = STACKS[name]
    wi, wo = pairs_above(100, 2, 0.1)
    sign = np.array(signs, np.float32)
    check_equal_means(run(stack, wi, wo, 3), run(stack, sign * wi, sign * wo, 4))


def crossed(stack: Stack) -> Stack:
    """The stack with its two widths exchanged."""
    result = dataclasses.replace(stack.bottom, alpha=_exchanged(stack.bottom.alpha))
    for layer in reversed(stack.coats):
        other = dataclasses.replace(layer, alpha=_exchanged(layer.alpha))
        result = Stack((other, *getattr(result, "coats", ())), getattr(result, "bottom", result))
    return result


def _exchanged(alpha):
    return Widths(alpha.v, alpha.u) if isinstance(alpha, Widths) else alpha


@pytest.mark.parametrize("name", ["bottom", "both", "three"])
def test_a_quarter_turn_exchanges_the_widths(name: str) -> None:
    wi, wo = pairs_above(100, 3, 0.1)
    a, b = (np.stack([-w[:, 1], w[:, 0], w[:, 2]], axis=1) for w in (wi, wo))
    stack = STACKS[name]
    check_equal_means(run(stack, wi, wo, 5), run(crossed(stack), a, b, 6))
    # The turn alone changes f, far beyond the noise.
    f, turned = run(stack, wi, wo, 5)[0], run(stack, a, b, 6)[0]
    assert np.mean(np.abs(turned / f - 1) > 0.2) > 0.1


@pytest.mark.parametrize("coats", [1, 2])
@pytest.mark.parametrize("kind", ["conductor", "conductor_complex", "dielectric"])
def test_equal_widths_give_the_walks_of_one_width(kind: str, coats: int) -> None:
    """The same paths on LLVM, up to rounding; CUDA divides approximately, and paths diverge."""
    if backend().__name__ != "drjit.llvm":
        pytest.skip("only LLVM divides exactly")
    one = random_table(kind, 8, coats, np.random.default_rng(7))
    bottom = dict(one.bottom)
    alpha = bottom.pop("alpha")
    two = dataclasses.replace(
        one,
        alpha=Widths(one.alpha, one.alpha),
        kind=f"{kind}_anisotropic",
        bottom={"alpha_u": alpha, "alpha_v": alpha, **bottom},
    )
    row, (wi, wo) = np.arange(64, dtype=np.uint32) % 8, pairs_above(64, 8, 0.1)
    f, se = walk_pairs(one, row, wi, wo, walks=256, seed=9)
    f_two, se_two = walk_pairs(two, row, wi, wo, walks=256, seed=9)
    np.testing.assert_allclose(f_two, f, rtol=1e-6)
    np.testing.assert_allclose(se_two, se, rtol=1e-5)
