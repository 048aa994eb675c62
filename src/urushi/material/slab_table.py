"""Tables of slabs that are the same from both sides: the light they reflect and transmit.

A slab is a medium between two interfaces of one width in one surrounding medium. Its reflection is
that of a coat over a bottom, the lower interface (`urushi.material.coated_table`). Its transmission
is tabulated in the coordinates of reflection (`urushi.material.table`), at the mirror image of wo
in the slab. Light that goes straight through a pane is then a narrow lobe at small half angles, and
exchanging wi and wo changes nothing. f of transmission is

    1 / eta^2 (E[w_i w_o S(wi', wo')] + integral of t(wi, w) t(wo, -w) a(w) / cos dw),

where wi' and wo' are wi and wo after refraction at random facets of their interfaces, w_i and w_o
the transmitted fractions (`urushi.material.crossing`), and t their products with densities. The
attenuation a counts light that goes straight or is mirrored to and fro, as between smooth surfaces,
and S all other light, which the medium scatters or rough interfaces reflect
(`urushi.material.adding`).
"""

from collections.abc import Callable

import numpy as np

from urushi.checks import CoatParameters
from urushi.core import fresnel
from urushi.core.namespace import NUMPY
from urushi.material import adding
from urushi.material.coated_table import coated_table
from urushi.material.crossing import Vector, cross, crossing_at, facet_points
from urushi.material.material import Material
from urushi.material.table import SHAPE, node_pairs, table_of_values
from urushi.nets import lobe as lobes
from urushi.nets.decoder import MIN_LOG
from urushi.nets.weights import Model
from urushi.parallel import fill_blocks

#: Directions inside for each node, drawn from either side.
STRAIGHT = 34

#: Facets at which light of a direction is refracted, and elevations outside.
FACETS, ELEVATIONS = 256, 48

#: Nodes of a table that are computed at once.
ROWS = 256


def slab_materials(model: Model, coat: CoatParameters) -> tuple[Material, Material]:
    """What a slab reflects and what it transmits, as materials with tables.

    Args:
        model: isotropic networks, of which nothing is used but the form of the codes.
        coat: checked numbers or arrays (C,), one alpha and one eta.

    Returns:
        The reflection, and the transmission as a function of wi and the mirror image of wo.
    """
    columns = np.stack(np.broadcast_arrays(*coat, np.zeros(1))[:5])
    alpha, eta, *media = columns
    codes = np.zeros((2, len(alpha), model.arch.latent), np.float32)
    codes[0, :, : model.arch.lobe] = lobes.of_coat(alpha, eta)
    codes[1, :, : model.arch.lobe] = lobes.of_coat(alpha, 1 / eta)
    empty = np.full((*SHAPE, len(alpha)), MIN_LOG, np.float16)
    below = Material(codes[1], model, table=empty, beside_lobe=True)
    lobe = codes[0, :, : model.arch.lobe]
    table = coated_table(below, CoatParameters(*columns), lobe, slab=True)
    reflected = Material(codes[0], model, table=table, beside_lobe=True)
    f = transmitted(float(alpha[0]), float(eta[0]), np.stack(media))
    return reflected, Material(codes[0], model, table=table_of_values(f))


def transmitted(alpha: float, eta: float, media: np.ndarray) -> np.ndarray:
    """f float32 (N, C) [1/sr] of transmission at `node_pairs` of wi and the mirror image of wo.

    Args:
        alpha, eta: of the upper interface, mirrored by the lower one.
        media: (3, C) albedo, sigma_t and g.
    """
    wi, wo = node_pairs()
    outside = adding.Grid(ELEVATIONS)
    back = adding.interface_modes(alpha, eta)
    passes = _crossing_modes(outside, alpha, eta) @ adding.without_trapped(back, eta)
    depths, scattered = [], []
    for medium in media.T:
        modes, depth = adding.passed_inside(back, *medium)
        through = passes @ modes @ passes.swapaxes(1, 2)
        scattered.append(outside.values_of_modes(through))
        depths.append(depth)
    f = np.empty((len(wi), len(depths)), np.float32)

    own = adding.grid()
    shares = own.mirror_shares(back) / np.maximum(back[0] @ own.weights, 1e-9)

    def attenuation(cosine: np.ndarray) -> np.ndarray:
        """What is left (..., C) of light that goes straight, however often it is mirrored."""
        left = np.exp(-np.array(depths, np.float32) / cosine[..., None])
        mirrored = fresnel.dielectric(cosine, np.float32(1 / eta), NUMPY)[0]
        mirrored = mirrored * np.interp(cosine, own.cosines[::-1], shares[::-1])
        return left / (1 - (mirrored[..., None] * left) ** 2)

    def straight(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return _straight(wi, wo, alpha, eta, attenuation)

    fill_blocks(f, straight, wi, wo, rows=ROWS)
    f += np.maximum(outside.interpolated(np.stack(scattered, axis=-1), wi, wo), 0)
    return f / np.float32(eta * eta)


def _crossing_modes(outside: adding.Grid, alpha: float, eta: float) -> np.ndarray:
    """Modes (H, M, N): shares of light of M directions outside that arrive at N nodes inside."""
    own = adding.grid()
    u = facet_points(FACETS)
    inside = cross(outside.cosines.astype(np.float32)[:, None], alpha, eta, u)
    x, y, z = inside.inside
    shares = own.shares(np.arccos(np.clip(z, 0, 1)))
    turn = np.arctan2(y, x)
    modes = []
    for order in range(len(own.azimuths)):
        weight = inside.weight * np.cos(order * turn) / FACETS
        modes.append(np.einsum("mk,mkn->mn", weight, shares))
    return np.stack(modes)


def _straight(
    wi: np.ndarray,
    wo: np.ndarray,
    alpha: float,
    eta: float,
    attenuation: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """The integral of the module's text for pairs (N, 3): (N, C).

    attenuation: the share (..., C) of light that is left of cosines inside (...).

    Half of the directions are drawn from wi, half from wo, weighted by the balance heuristic.
    """
    u = facet_points(STRAIGHT)
    total = np.float32(0)
    for one, other in ((wi, wo), (wo, wi)):
        cosine = one[:, 2, None]
        a = cross(cosine, alpha, eta, u)
        turn = np.arctan2(one[:, 1], one[:, 0])[:, None]
        cos, sin = np.cos(turn), np.sin(turn)
        x, y, z = a.inside
        inside: Vector = (sin * y - cos * x, -cos * y - sin * x, z)  # mirrored
        b = crossing_at(tuple(other[:, i, None] for i in range(3)), inside, alpha, eta)
        chances = a.density * b.density / np.maximum(a.density + b.density, np.float32(1e-30))
        weight = a.weight * b.weight * chances / (z * STRAIGHT)
        total = total + np.einsum("nk,nkc->nc", weight, attenuation(z))
    return np.asarray(total)
