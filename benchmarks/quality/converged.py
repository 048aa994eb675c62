"""Pictures of scenes with many samples, stored in files so that stopped runs resume.

Samples are accumulated in two independent halves, from which the remaining noise is estimated.
"""

import argparse
import hashlib
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks.scenes import OWN, SCENES, WALK, describe, digest
from tqdm import tqdm

from urushi.core import error_metrics as metrics
from urushi.files import atomic_write, new_folder
from urushi.nets import weights as networks

#: Samples per pixel of one pass, which bounds the memory; and seconds between two saves.
PASS_SPP, SAVE_EVERY = 16, 30.0
#: The method of the reference, see `benchmarks.scenes`.
REFERENCE = WALK


@dataclass(frozen=True)
class Picture:
    """Means (H, W, 3) of two independent halves of the samples, linear radiance."""

    first: np.ndarray
    second: np.ndarray

    @property
    def image(self) -> np.ndarray:
        return (self.first + self.second) / 2

    @property
    def noise(self) -> float:
        """Mean over all pixels of the image's variance, an unbiased estimate."""
        return float(metrics.halves_variance(self.first, self.second).mean())


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments that all benchmarks of pictures share."""
    parser.add_argument("--scenes", nargs="+", default=SCENES, choices=SCENES, help="scenes")
    parser.add_argument(
        "--weights", nargs="+", default=[networks.DEFAULT], help="weights of neural_layered"
    )
    parser.add_argument(
        "--width", type=int, default=320, help="width of pictures [pixels]; the height is 3/4 of it"
    )
    parser.add_argument("--detail", type=float, default=1.0, help="scale of the sizes of textures")
    parser.add_argument("--depth", type=int, default=6, help="longest path; 2: direct light alone")
    parser.add_argument("--mode", default="llvm_ad_rgb", help="Mitsuba variant")
    parser.add_argument(
        "--folder", type=Path, default=Path("runs/pictures"), help="folder of results"
    )


def load(
    name: str, method: str, arguments: argparse.Namespace, light: str = OWN
) -> tuple[Any, str]:
    """A scene for `mi.render`, and the hash of everything that its picture depends on.

    Args:
        name, method, light: as of `scenes.describe`.
        arguments: those of `add_arguments`.
    """
    with tempfile.TemporaryDirectory(prefix="urushi-") as folder:
        options = {key: getattr(arguments, key) for key in ("width", "detail", "depth")}
        scene = describe(name, method, Path(folder), light=light, **options)
        return mi.load_dict(scene), f"{digest(scene)} {PASS_SPP}"


def converged(
    name: str, method: str, spp: int, arguments: argparse.Namespace, light: str = OWN
) -> Picture:
    """Render a scene with `spp` samples per pixel, less those that are already stored."""
    new_folder(arguments.folder)
    path = arguments.folder / f"{name}-{light}-{Path(method).stem}-{arguments.width}.npz"
    scene, key = load(name, method, arguments, light)
    sums, done = _saved(path, key, (arguments.width * 3 // 4, arguments.width))
    passes = max(2, 2 * round(spp / PASS_SPP / 2))
    saved = time.monotonic()
    for index in tqdm(range(done, passes), desc=f"{name}, {method}", initial=done, total=passes):
        # Methods have different seeds, so that two pictures share no noise.
        seed = int(hashlib.sha256(f"{method} {index}".encode()).hexdigest()[:8], 16)
        sums[index % 2] += mi.render(scene, spp=PASS_SPP, seed=seed).numpy()
        if time.monotonic() - saved > SAVE_EVERY or index == passes - 1:
            with atomic_write(path) as temporary:
                np.savez(temporary, sums=sums, passes=index + 1, key=key)
            saved = time.monotonic()
    count = max(passes, done)
    return Picture(sums[0] / ((count + 1) // 2), sums[1] / (count // 2))


def _saved(path: Path, key: str, size: tuple[int, int]) -> tuple[np.ndarray, int]:
    """Sums of the saved passes of both halves (2, H, W, 3), and the number of passes."""
    if path.exists():
        with np.load(path) as file:
            if str(file["key"]) == key:
                return file["sums"], int(file["passes"])
    return np.zeros((2, *size, 3)), 0
