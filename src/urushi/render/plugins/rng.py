"""Random numbers for a BSDF that needs its own: Mitsuba hands none to `eval`."""

import drjit as dr
import mitsuba as mi

from urushi.reference.rng import mix64


def hashed(si, wo) -> "mi.PCG32":
    """A generator per lane, seeded by every bit of what is asked: wi, wo, position, uv and time.

    The same question gets the same answer, and different samples of a pixel, which differ in
    position or direction, get independent ones.
    """
    state = mi.UInt64(0)
    for value in (*si.wi, *wo, *si.p, *si.uv, si.time):
        bits = mi.UInt64(dr.reinterpret_array(mi.UInt32, value))
        state = mix64(state * 0x9E3779B97F4A7C15 + bits + 1)
    rng = mi.PCG32(size=1, initstate=0, initseq=0)
    rng.state = state
    rng.inc = mix64(state + 0x9E3779B97F4A7C15) | 1
    rng.next_uint32()  # the first output is a plain function of the state: skip it
    return rng
