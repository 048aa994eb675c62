"""Pictures rendered in passes: progress is shown, memory is bounded, and an interrupt is heard."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from tqdm import tqdm

#: Camera rays of a pass, at most. Recording a pass takes up to half a second, so that fewer cost
#: time.
RAYS = 1 << 22


def passes(
    scene: Any, spp: int, seed: int, step: int, *, sensor: int = 0, title: str | None = None
) -> Iterator[tuple[np.ndarray, int]]:
    """Render a scene in passes of `step` samples per pixel; yields pictures and their samples.

    Each pass has a seed of its own, which depends only on `seed` and its number. The last one has
    the samples that remain of `spp`. title: of the progress bar, which only a terminal shows.

    Yields:
        float64 (H, W, C), and the number of its samples per pixel.
    """
    import mitsuba as mi

    with tqdm(total=spp, desc=title, unit=" spp", disable=None) as progress:
        for index, first in enumerate(range(0, spp, step)):
            samples = min(step, spp - first)
            own = int(np.random.SeedSequence(seed, spawn_key=(index,)).generate_state(1)[0])
            picture = mi.render(scene, sensor=sensor, spp=samples, seed=own)
            yield np.array(picture, np.float64), samples
            progress.update(samples)


def rendered(scene: Any, sensor: int, spp: int, seed: int, rays: int = RAYS) -> np.ndarray:
    """The picture (H, W, C) of `spp` samples per pixel, the mean over its passes.

    It depends only on the arguments. rays: of the camera in a pass, at most.
    """
    width, height = scene.sensors()[sensor].film().crop_size()
    step = 1  # a power of four, which no sampler of Mitsuba rounds
    while 4 * step * width * height <= rays:
        step *= 4
    parts = passes(scene, spp, seed, step, sensor=sensor)
    return sum((picture * samples for picture, samples in parts), start=np.zeros(())) / spp
