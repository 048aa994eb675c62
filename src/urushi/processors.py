"""How many cores this process may use, of those that the machine has."""

import math
import os
from pathlib import Path

#: What a container is allowed: microseconds of processor time in each so many, or "max" (the file
#: `cpu.max` of control groups, version 2).
ALLOWANCE = Path("/sys/fs/cgroup/cpu.max")


def available() -> int:
    """Cores that this process may use, at least 1.

    Those of its affinity mask, and no more than a container's limit of processor time pays for.
    """
    if hasattr(os, "sched_getaffinity"):
        count = len(os.sched_getaffinity(0))
    else:
        count = os.cpu_count() or 1
    try:
        share, period = ALLOWANCE.read_text(encoding="ascii").split()
        return max(min(count, math.ceil(int(share) / int(period))), 1)
    except (OSError, ValueError):  # no such file, or no limit
        return count
