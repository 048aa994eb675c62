"""CPU time of the tables of slabs: `python -m benchmarks.speed.slabs`; a minute on an idle core.

Prints the least CPU time [s] of three computations on one thread, for one channel and for three.
"""

import time

import numpy as np

from urushi.material import adding
from urushi.material.slab_table import slab_tables
from urushi.nets.weights import default_model
from urushi.parallel import one_blas_thread

#: Media (albedo, sigma_t, g) of three channels.
CLEAR = np.zeros(3), np.zeros(3), np.zeros(3)
TINTED = np.array([0.9, 0.5, 0.2]), np.array([0.5, 1.0, 2.0]), np.full(3, 0.3)
#: Interfaces (alpha, index relative to the medium above), and the media between them.
SLABS = {
    "a sheet of one coat": ([(0.3, 1.4), (0.3, 1 / 1.4)], [TINTED]),
    "a coat on a body of glass": ([(0.1, 1.3), (0.2, 1.5 / 1.3)], [TINTED]),
    "a coat on a pane": ([(0.2, 1.4), (0.03, 1.1), (0.03, 1 / 1.54)], [TINTED, CLEAR]),
    "a clear pane with coats on both sides": (
        [(0.1, 1.4), (0.03, 1.5 / 1.4), (0.03, 1.3 / 1.5), (0.2, 1 / 1.3)],
        [TINTED, CLEAR, TINTED],
    ),
    "three coats with media": (
        [(0.1, 1.4), (0.3, 1.2), (0.2, 0.9), (0.15, 1 / (1.4 * 1.2 * 0.9))],
        [TINTED, TINTED, TINTED],
    ),
}


def seconds(interfaces: list, media: list, channels: int) -> float:
    """CPU time of the tables of a slab [s], without what former ones have left."""
    for function in vars(adding).values():
        getattr(function, "cache_clear", int)()
    values = np.array(media)[..., :channels]
    start = time.process_time()
    slab_tables(default_model(), np.array(interfaces), values)
    return time.process_time() - start


def main() -> None:
    """Print the table."""
    with one_blas_thread():
        seconds(*SLABS["a sheet of one coat"], 1)  # reads the networks
        for name, slab in SLABS.items():
            times = [min(seconds(*slab, channels) for _ in range(3)) for channels in (1, 3)]
            print(f"{name:40}" + "".join(f"{value:8.2f}" for value in times))


if __name__ == "__main__":
    main()
