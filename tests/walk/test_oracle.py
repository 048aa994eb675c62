"""The random walk against an independent simulator's values."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest

from urushi.walk import Stack, StackTable, coat, conductor, diffuse, walk_pairs
from urushi.walk.table import from_stack

#: A standard error of 0.8 % in the median, of up to 1 % with the later oracle; their own is 1 %.
WALKS = 1 << 12


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
    alpha, eta, sigma_t, albedo, g = np.concatenate([columns[:5], columns[5:10]], axis=2)
    bottom = {"alpha": columns[10][:, 0], "r0": columns[11][:, 0]}
    return StackTable(alpha, eta, albedo, sigma_t, g, "conductor", bottom)


def compare(walked, reference, deviation: float) -> float:
    """f and its standard error of configurations and pairs, (2, K, P) each; the mean of squares.

    float32 and rounded parameters on both sides: a difference of 0.2 % of f is allowed. Four
    standard errors are. That of the median of n deviations is 1.25 times one by sqrt(n). That of
    the mean of n squares is sqrt(2 / n), here doubled because the noise of walks has long tails.
    """
    (f, se), (expected, error) = np.float64(walked), np.float64(reference)
    ratio, z2 = f / expected, (f - expected) ** 2 / (se**2 + error**2 + (0.002 * f) ** 2)
    assert abs(np.median(ratio) - 1) < 0.003
    assert z2.mean() < 1.4
    count = f.shape[1]
    assert np.abs(np.median(ratio, axis=1) - 1).max() < 4 * 1.25 * deviation / np.sqrt(count)
    assert z2.mean(axis=1).max() < 1 + 8 * np.sqrt(2 / count)
    return z2.mean()


@pytest.mark.parametrize("family", ["two", "three", "lambert"])
def test_every_configuration_agrees(family: str, stored: Callable[[str], Path]) -> None:
    """With an independent simulator (see the README of its values)."""
    oracle = np.load(stored("oracle/reference_values.npz"))
    # Every fourth pair of the longest lists, to cover all kinds of pairs in less time.
    step = 4 if family == "two" else 1
    wi, wo, f, se = (oracle[f"{family}_{name}"][:, ::step] for name in ("wi", "wo", "f", "se"))
    row = np.repeat(np.arange(len(f), dtype=np.uint32), f.shape[1])
    sides = (w.reshape(-1, 3).astype(np.float32) for w in (wi, wo))
    walked = walk_pairs(table(oracle, family), row, *sides, walks=WALKS, seed=1)
    squares = compare(np.reshape(walked, (2, *f.shape)), (f, se), 0.013)
    assert squares > 0.5  # else the standard errors are too large


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
    group: str, stored: Callable[[str], Path]
) -> None:
    """With a third simulator. The groups are named after the anisotropic surfaces; `low` has index
    ratios below one."""
    oracle = np.load(stored("oracle/anisotropic.npz"))
    stacks, wi, wo, f, se = (oracle[f"{group}_{name}"] for name in ("stack", "wi", "wo", "f", "se"))
    row = np.zeros(f.shape[1], np.uint32)
    walked = [
        walk_pairs(from_stack(later_stack(rows)), row, *sides, walks=WALKS, seed=1)
        for rows, *sides in zip(stacks, np.float32(wi), np.float32(wo), strict=True)
    ]
    compare(np.swapaxes(walked, 0, 1), (f, se), 0.015)
