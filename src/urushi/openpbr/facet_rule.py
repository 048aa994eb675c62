"""Quadratures over visible facets, for functions of the cosine to the facet.

The directional albedo of an interface is a mean, over visible facets, of the reflectance times
masking. A reflectance that is known only during rendering, such as that of a thin film, is
evaluated at the nodes of a Gauss rule, which is exact for polynomials in the cosine to the facet.
"""

import functools
from typing import NamedTuple

import numpy as np

from urushi.openpbr import albedo_axes, interface_albedo

#: Nodes of a rule from one direction, and of one for diffuse light.
NODES, MEAN_NODES = 4, 4


class Rules(NamedTuple):
    """Gauss rules at the nodes of `interface_albedo`, float32; weights have a sum of one.

    Attributes:
        cosines, weights: (ROUGHNESSES, COSINES, NODES) of the facets seen from a direction.
        mean_cosines, mean_weights: (ROUGHNESSES, MEAN_NODES) of those that diffuse light meets.
    """

    cosines: np.ndarray
    weights: np.ndarray
    mean_cosines: np.ndarray
    mean_weights: np.ndarray


@functools.cache
def rules() -> Rules:
    """The rules of GGX facets with Smith's masking."""
    alphas, cosine = albedo_axes.nodes()
    found, means = [], []
    light = albedo_axes.hemisphere_mean(np.eye(len(cosine)))
    for alpha in alphas:
        facets, weight = interface_albedo.seen_facets(alpha, cosine)
        found.append(gauss_rule(facets, weight, NODES))
        weight = weight * light[:, None]
        means.append(gauss_rule(facets.ravel(), weight.ravel(), MEAN_NODES))
    tables = [np.stack(x) for pairs in (found, means) for x in zip(*pairs, strict=True)]
    return Rules(*(table.astype(np.float32) for table in tables))


def gauss_rule(x: np.ndarray, weight: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The Gauss rules of discrete measures.

    Args:
        x: (..., K) points in [0, 1]. weight: their weights, not negative.
        count: of nodes, N.

    Returns:
        Nodes within [0, 1] and weights of sum one, (..., N).

    Source: Golub and Welsch 1969; the recurrence of orthogonal polynomials by Stieltjes' procedure.
    """
    weight = weight / weight.sum(-1, keepdims=True)
    former, present = np.zeros_like(x), np.ones_like(x)
    matrix = np.zeros((*x.shape[:-1], count, count))
    for k in range(count):
        matrix[..., k, k] = (weight * x * present**2).sum(-1)
        following = (x - matrix[..., k, k, None]) * present
        if k:
            following -= matrix[..., k, k - 1, None] * former
        norm = np.sqrt((weight * following**2).sum(-1))
        if k + 1 < count:
            matrix[..., k, k + 1] = matrix[..., k + 1, k] = norm
        former, present = present, following / np.maximum(norm, 1e-300)[..., None]
    nodes, vectors = np.linalg.eigh(matrix)
    return np.clip(nodes, 0, 1), vectors[..., 0, :] ** 2
