"""Reference values for tests of layered BSDFs: `python -m benchmarks.layering_values`.

Writes docs/layering_values.json (docs/layering_in_mitsuba.md describes it), in a minute on two idle
cores: f of stacks at pairs of directions and their directional albedos, by the walk.
"""

import json
from dataclasses import asdict
from typing import Any

import numpy as np
from benchmarks.experiment import ROOT, rounded
from benchmarks.referee import materials

import urushi
from urushi.core.direction_sets import Pairs
from urushi.files import atomic_write
from urushi.walk import Stack
from urushi.walk.simulate import albedo

FILE = ROOT / "docs" / "layering_values.json"
#: Stride of the referee's pairs that are taken; walks of each pair; the seed.
EVERY, WALKS, SEED = 64, 1 << 16, 1918
#: Stacks from a single interface to two coats.
STACKS: dict[str, Stack] = {
    "interface": urushi.coat(urushi.diffuse(0.0), 0.2, 1.5),
    "white, smooth coat": urushi.coat(urushi.diffuse(1.0), 0.03, 1.5),
    "white, rough coat": urushi.coat(urushi.diffuse(1.0), 0.5, 1.5),
    "air under glass": urushi.coat(urushi.diffuse(0.5), 0.2, 0.67),
    **{
        name: materials.STACKS[name]
        for name in (
            *("varnish, amber gloss", "car paint, silver flake", "car paint, pearl"),
            *("enamel, cobalt on copper", "coated metal, steel, frosted"),
            "coated metal, silver, hazy",
        )
    },
}


def directions() -> tuple[Pairs, np.ndarray]:
    """Pairs float32 (N, 3), and the directions of the albedos (C, 3)."""
    wi, wo = materials.pairs()
    return (wi[::EVERY], wo[::EVERY]), materials.lit()


def described(stack: Stack) -> dict[str, Any]:
    """A stack as JSON has it."""
    own: dict[str, Any] = {"coats": [asdict(coat) for coat in stack.coats]}
    own["bottom"] = {"type": type(stack.bottom).__name__} | asdict(stack.bottom)
    for part in (*own["coats"], own["bottom"]):
        for name in [k for k, value in part.items() if value is None or value is False]:
            del part[name]
    return json.loads(json.dumps(own))


def main() -> None:
    pairs, lit = directions()
    wi, wo = (rounded(w, 9) for w in pairs)
    found: dict[str, Any] = {"version": 1, "licence": "CC0-1.0", "wi": wi, "wo": wo}
    found |= {"lit": rounded(lit, 9), "stacks": {}}
    for name, stack in STACKS.items():
        own = described(stack)
        f, se = urushi.simulate(stack, *pairs, walks=WALKS, seed=SEED, progress=False)
        own |= {"f": rounded(f, 5), "f_se": rounded(se, 2)}
        f, se = albedo(stack, lit, walks=WALKS, seed=SEED)
        found["stacks"][name] = own | {"albedo": rounded(f, 5), "albedo_se": rounded(se, 2)}
    text = json.dumps(found, separators=(",", ":")).replace('},"', '},\n"').replace("]],", "]],\n")
    with atomic_write(FILE) as temporary:
        temporary.write_text(text + "\n")


if __name__ == "__main__":
    main()
