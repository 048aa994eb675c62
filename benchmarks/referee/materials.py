"""The forty coated materials of the referee, its white ones, and the pairs of directions."""

import numpy as np
from benchmarks.measures import in_plane

from urushi import coat, conductor, diffuse
from urushi.core import direction_sets
from urushi.core.direction_sets import Pairs
from urushi.walk import Stack

OAK, WALNUT, PINE = (0.45, 0.28, 0.14), (0.26, 0.14, 0.07), (0.6, 0.45, 0.28)
CLAY, AMBER, SKIN = (0.62, 0.5, 0.4), (0.95, 0.7, 0.35), (0.6, 0.55, 0.45)
GOLD, COPPER, STEEL = (0.98, 0.77, 0.34), (0.95, 0.64, 0.54), (0.62, 0.6, 0.58)
SILVER, BRASS = (0.96, 0.94, 0.9), (0.89, 0.75, 0.42)
BLUE, GREEN, RED = (0.2, 0.4, 0.85), (0.15, 0.6, 0.3), (0.8, 0.08, 0.06)

#: Stacks by family and name. `color` tints a clear medium, `body` is the opacity of pigment.
MATERIALS: dict[str, dict[str, Stack]] = {
    "varnish": {
        "clear gloss": coat(diffuse(OAK), 0.05, 1.5),
        "amber gloss": coat(diffuse(OAK), 0.05, 1.5, color=AMBER),
        "amber satin": coat(diffuse(WALNUT), 0.25, 1.5, color=AMBER),
        "matte": coat(diffuse(WALNUT), 0.45, 1.5),
        "two coats": coat(coat(diffuse(PINE), 0.15, 1.1, color=AMBER), 0.05, 1.4),
        "stain": coat(diffuse(PINE), 0.1, 1.5, body=0.4, body_color=(0.1, 0.05, 0.04)),
    },
    "car paint": {
        "silver flake": coat(conductor(0.3, SILVER), 0.05, 1.5),
        "blue flake": coat(conductor(0.35, STEEL), 0.05, 1.5, color=BLUE),
        "candy red": coat(conductor(0.2, SILVER), 0.05, 1.5, color=RED),
        "solid red": coat(diffuse((0.6, 0.03, 0.03)), 0.05, 1.5),
        "pearl": coat(coat(conductor(0.25, SILVER), 0.15, 1.1, body=0.4), 0.05, 1.5),
        "matte grey": coat(conductor(0.3, STEEL), 0.4, 1.5, body=0.2, body_color=0.3),
    },
    "enamel": {
        "cobalt on copper": coat(conductor(0.2, COPPER), 0.05, 1.6, body=0.8, body_color=BLUE),
        "white on steel": coat(conductor(0.3, STEEL), 0.05, 1.6, body=0.9),
        "green on silver": coat(conductor(0.1, SILVER), 0.05, 1.6, color=GREEN),
        "thin red on gold": coat(conductor(0.15, GOLD), 0.05, 1.6, body=0.3, body_color=RED),
        "matte black": coat(conductor(0.3, STEEL), 0.4, 1.6, body=0.9, body_color=0.05),
    },
    "glaze": {
        "celadon": coat(diffuse(CLAY), 0.05, 1.5, color=(0.65, 0.85, 0.7)),
        "matte": coat(diffuse(CLAY), 0.35, 1.5),
        "honey": coat(diffuse(CLAY), 0.1, 1.6, color=(0.8, 0.5, 0.15)),
        "tin white": coat(diffuse(CLAY), 0.05, 1.55, body=0.9),
        "blue": coat(diffuse(0.8), 0.05, 1.5, color=BLUE),
        "two glazes": coat(coat(diffuse(CLAY), 0.2, 1.2, body=0.5), 0.05, 1.45, color=GREEN),
    },
    "coated metal": {
        "gold, clear": coat(conductor(0.1, GOLD), 0.05, 1.5),
        "gold, satin": coat(conductor(0.2, GOLD), 0.3, 1.5),
        "copper, lacquer": coat(conductor(0.15, COPPER), 0.1, 1.5, color=AMBER),
        "steel, frosted": coat(conductor(0.4, STEEL), 0.5, 1.5),
        "silver, polished": coat(conductor(0.05, SILVER), 0.05, 1.4),
        "brass, high index": coat(conductor(0.15, BRASS), 0.1, 1.8),
        "silver, hazy": coat(conductor(0.1, SILVER), 0.1, 1.5, albedo=0.9, sigma_t=0.5),
    },
    "fabric under lacquer": {
        "carbon weave": coat(conductor(0.5, 0.08), 0.05, 1.55),
        "silk": coat(conductor(0.6, (0.5, 0.05, 0.08)), 0.1, 1.5),
        "linen": coat(diffuse(SKIN), 0.2, 1.45),
        "denim": coat(diffuse((0.08, 0.12, 0.3)), 0.1, 1.5, color=(0.9, 0.85, 0.6)),
        "waxed felt": coat(diffuse(RED), 0.5, 1.4, albedo=0.8, sigma_t=0.5),
    },
    "glass": {
        "white behind": coat(diffuse(0.8), 0.03, 1.52),
        "black behind": coat(diffuse(0.04), 0.03, 1.52),
        "mirror": coat(conductor(0.05, SILVER), 0.03, 1.52),
        "frosted mirror": coat(conductor(0.05, SILVER), 0.35, 1.52),
        "opal": coat(diffuse(0.5), 0.1, 1.52, body=0.8),
    },
}
STACKS = {f"{family}, {name}": s for family, own in MATERIALS.items() for name, s in own.items()}
#: Coats over white, which absorb nothing.
WHITE = {
    f"{name} under {alpha:g}": coat(bottom, alpha, 1.5)
    for name, bottom in (("diffuse", diffuse(1.0)), ("metal", conductor(0.2, 1.0)))
    for alpha in (0.05, 0.3, 0.6)
}
#: Cosines at which white materials are lit, in the xz plane.
COSINES = (1.0, 0.6, 0.3)


def lit() -> np.ndarray:
    """Directions float32 (C, 3) of `COSINES`, in the xz plane."""
    return in_plane(np.arccos(COSINES))


SEED, LOWEST_COSINE = 40, 0.02
#: Angles between the directions of a pair, pairs of each, and drawn ones of which these are taken.
ANGLES, EACH, DRAWN = 32, 32, 160


def pairs() -> Pairs:
    """Pairs float32 (ANGLES x EACH, 3) of cosine density on both sides, by ascending angle.

    The directions of a pair have one of `ANGLES` angles between them: the azimuth of wo is moved to
    the nearest one. A renderer then needs one distant light for each angle.
    """
    wi, wo = direction_sets.cosine_pairs(
        np.random.default_rng(SEED), ANGLES * DRAWN, lowest_cosine=LOWEST_COSINE
    )
    wi, wo = (np.asarray(w, np.float64) for w in (wi, wo))
    groups = np.argsort(-(wi * wo).sum(1)).reshape(ANGLES, DRAWN)
    chosen = []
    for group in groups:
        a, b = wi[group], wo[group]
        target = np.median((a * b).sum(1))
        sines = np.sqrt((1 - a[:, 2] ** 2) * (1 - b[:, 2] ** 2))
        turn = (target - a[:, 2] * b[:, 2]) / np.maximum(sines, 1e-9)
        kept = np.flatnonzero(np.abs(turn) < 1)[:EACH]
        a, b, turn = a[kept], b[kept], np.arccos(turn[kept])
        side = np.where(np.cross(a, b)[:, 2] < 0, -1, 1)
        azimuth = np.arctan2(a[:, 1], a[:, 0]) + side * turn
        radius = np.sqrt(1 - b[:, 2] ** 2)
        b = np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), b[:, 2]], axis=-1)
        chosen.append((a, b))
    first, second = (np.concatenate(part).astype(np.float32) for part in zip(*chosen, strict=True))
    return first, second
