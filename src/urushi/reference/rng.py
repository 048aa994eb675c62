"""Independent random streams for Dr.Jit lanes, reproducible from a seed."""

from typing import Any

import drjit as dr


def mix64(x: Any) -> Any:
    """SplitMix64's finaliser (Steele, Lea & Flood 2014): a bijection that scatters all bits."""
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9
    x = (x ^ (x >> 27)) * 0x94D049BB133111EB
    return x ^ (x >> 31)


def stream(pcg: type, index: Any, seed: int) -> Any:
    """A PCG32 per lane, of type `pcg`, fixed by the lane's uint64 `index` and the `seed`."""
    uint64 = dr.uint64_array_t(type(index))
    state = mix64(uint64(index) * 0x9E3779B97F4A7C15 + uint64(seed & 0xFFFFFFFFFFFFFFFF))
    rng = pcg(size=1, initstate=0, initseq=0)
    rng.state = state
    rng.inc = mix64(state + 0x9E3779B97F4A7C15) | 1
    rng.next_uint32()  # the first output is a plain function of the state: skip it
    return rng
