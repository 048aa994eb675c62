"""Independent, reproducible random generators for the lanes of a Dr.Jit kernel."""

from collections.abc import Sequence
from typing import Any

import drjit as dr

#: Increment of SplitMix64, the golden ratio's fraction in 64 bits.
INCREMENT = 0x9E3779B97F4A7C15


def mix64(x: Any) -> Any:
    """SplitMix64's finaliser (Steele, Lea & Flood 2014): a bijection that scatters all bits."""
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9
    x = (x ^ (x >> 27)) * 0x94D049BB133111EB
    return x ^ (x >> 31)


def stream(pcg: type, index: Any, seed: int) -> Any:
    """A generator per lane that depends on the lane's index, unsigned, and a seed, any integer.

    pcg: the backend's PCG32 type.
    """
    uint64 = dr.uint64_array_t(type(index))
    return _generator(pcg, mix64(uint64(index) * INCREMENT + uint64(seed & 0xFFFFFFFFFFFFFFFF)))


def hashed_stream(pcg: type, values: Sequence[Any]) -> Any:
    """A generator per lane, seeded by every bit of float32 values.

    Equal values give equal generators; values that differ in one bit give independent ones.
    """
    scalar = type(values[0])
    uint32, uint64 = dr.uint32_array_t(scalar), dr.uint64_array_t(scalar)
    state = uint64(0)
    for value in values:
        state = mix64(state * INCREMENT + uint64(dr.reinterpret_array(uint32, value)) + 1)
    return _generator(pcg, state)


def _generator(pcg: type, state: Any) -> Any:
    """A PCG32 per lane of this state, with a sequence of its own."""
    rng = pcg(size=1, initstate=0, initseq=0)
    rng.state = state
    rng.inc = mix64(state + INCREMENT) | 1
    rng.next_uint32()  # the first output is a plain function of the state: skip it
    return rng
