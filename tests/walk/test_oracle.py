"""The random walk against an independent simulator's values."""

from collections.abc import Mapping

import numpy as np
import pytest

from urushi.walk import Stack, StackTable, coat, conductor, diffuse, walk_pairs
from urushi.walk.table import from_stack

WALKS = 1 << 13  # a standard error of 0.6 % in the median; the reference's own is 1 %
LATER_WALKS = 1 << 12  # up to 1 % in the medians of the later oracle, as its own


def table(oracle: Mapping[str, np.ndarray], family: str) -> StackTable:
    """The oracle's configurations of a family as a table, one row each."""
    columns = oracle[f"{family}_cfg"].T[:, :, None]
    if family == "two":
        alpha, eta, sigma_t, albedo, g, alpha_bottom, r0 = columns
        bottom = {"alpha": alpha_bottom[:, 0], "r0": r0[:, 0]}
        return StackTable(alpha, eta, albedo, sigma_t, g, "conductor", bottom)
    if family == "lambert":
        alpha, eta, sigma_t, albedo, rho = columns
        bottom = {"reflectance": rho[:, 0]}
        return StackTable(alpha, eta, albedo, sigma_t, 0 * alpha, "diffuse", bottom)
    coats = [np.concatenate([columns[i], columns[i + 5]], axis=1) for i in range(5)]
    alpha, eta, sigma_t, albedo, g = coats
    bottom = {"alpha": columns[10][:, 0], "r0": columns[11][:, 0]}
    return StackTable(alpha, eta, albedo, sigma_t, g, "conductor", bottom)


@pytest.mark.parametrize("family", ["two", "three", "lambert"])
def test_every_configuration_agrees(family: str, oracle: Mapping[str, np.ndarray]) -> None:
    # Every fourth pair of the longest lists, to cover all kinds of pairs in less time.
    step = 4 if family == "two" else 1
    wi, wo, reference, se_reference = (
        oracle[f"{family}_{name}"][:, ::step] for name in ("wi", "wo", "f", "se")
    )
    count, pairs = reference.shape
    wi, wo = (w.reshape(-1, 3).astype(np.float32) for w in (wi, wo))
    row = np.repeat(np.arange(count, dtype=np.uint32), pairs)
    f, se = walk_pairs(table(oracle, family), row, wi, wo, walks=WALKS, seed=1)
    f, se = (x.reshape(count, pairs).astype(np.float64) for x in (f, se))
    # float32 and rounded parameters on both sides: a difference of 0.2 % of f is allowed.
    variance = se**2 + se_reference**2 + (0.002 * f) ** 2
    ratio, z2 = f / reference, (f - reference) ** 2 / variance
    assert abs(np.median(ratio) - 1) < 0.003
    assert 0.5 < z2.mean() < 1.4  # else the standard errors are too large
    # Four standard errors are allowed. That of the median of n deviations of 1.1 % is
    # 1.25 * 1.1 % / sqrt(n). That of the mean of n squares is sqrt(2 / n), here doubled because
    # the noise of walks has long tails.
    assert np.abs(np.median(ratio, axis=1) - 1).max() < 4 * 1.25 * 0.011 / np.sqrt(pairs)
    assert z2.mean(axis=1).max() < 1 + 8 * np.sqrt(2 / pairs)


def later_stack(rows: np.ndarray) -> Stack:
    """A stack of the later oracle; rows from top to bottom."""
    *coats, bottom = rows[~np.isnan(rows[:, 0])]
    width_u, reflectance, *_, width_v = bottom
    if width_u < 0:
        stack = diffuse(reflectance)
    else:
        stack = conductor(alpha_u=width_u, alpha_v=width_v, r0=reflectance)
    for alpha_u, eta, single, sigma_t, g, alpha_v in reversed(coats):
        stack = coat(*(stack, None, eta, single, sigma_t, g), alpha_u=alpha_u, alpha_v=alpha_v)
    return stack


@pytest.mark.parametrize("group", ["top", "bottom", "three", "low"])
def test_anisotropic_surfaces_and_indices_below_one_agree(
    later_oracle: Mapping[str, np.ndarray], group: str
) -> None:
    """The groups are named after the anisotropic surfaces; `low` has index ratios below one."""
    ratios, squares = [], []
    for number, rows in enumerate(later_oracle[f"{group}_stack"]):
        wi, wo, reference, se_reference = (
            later_oracle[f"{group}_{name}"][number] for name in ("wi", "wo", "f", "se")
        )
        table = from_stack(later_stack(rows))
        wi, wo = (w.astype(np.float32) for w in (wi, wo))
        f, se = walk_pairs(table, np.zeros(len(wi), np.uint32), wi, wo, walks=LATER_WALKS, seed=1)
        ratios.append(f / reference)
        # As above, 0.2 % of f is allowed for float32 on both sides.
        squares.append((f - reference) ** 2 / (se**2 + se_reference**2 + (0.002 * f) ** 2))
        # Four standard errors of the median of 300 deviations of 1.5 % and of a mean of squares,
        # doubled for the long tails of walks.
        assert abs(np.median(ratios[-1]) - 1) < 4 * 1.25 * 0.015 / np.sqrt(len(f))
        assert squares[-1].mean() < 1 + 8 * np.sqrt(2 / len(f))
    assert abs(np.median(ratios) - 1) < 0.003
    assert np.mean(squares) < 1.4
