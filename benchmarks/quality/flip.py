"""FLIP between converged pictures of networks and walk: `python -m benchmarks.quality.flip`.

Renders each scene of the gallery with `neural_layered` and with `layered`, and prints

- the mean FLIP (Andersson et al. 2020) of the displayed pictures, sRGB clipped at 1; the aim is
  0.02;
- HDR-FLIP (2021) of the radiance, the largest error over all exposures;
- the same two figures for noise alone: between two halves of the reference's samples, which are
  noisier than the whole;
- the relative mean squared error with the noise subtracted;
- the relative difference of the mean radiance.

With default sizes it takes one to two hours on two cores; `--width 160 --spp 512` takes ten
minutes. Pictures are stored in `--folder`, and a stopped run resumes. Reference, networks and the
map of FLIP are written there side by side. Needs the package flip-evaluator, of the extra `eval`.
"""

import argparse
from pathlib import Path

import flip_evaluator
import mitsuba as mi
import numpy as np
from benchmarks.quality.converged import REFERENCE, Picture, add_arguments, converged

from urushi.app.demo import side_by_side, srgb, write_png
from urushi.core import error_metrics as metrics

AIM = 0.02


def shown(image: np.ndarray) -> np.ndarray:
    """The displayed picture: sRGB (H, W, 3) float32 in [0, 1]."""
    return srgb(np.clip(image, 0, 1)).astype(np.float32)


def flip(image: np.ndarray, reference: np.ndarray) -> tuple[np.ndarray, float, float]:
    """The map of FLIP in false colours, the mean of FLIP, and the mean of HDR-FLIP."""
    colours, mean, _ = flip_evaluator.evaluate(shown(reference), shown(image), "LDR")
    radiance = (np.maximum(x, 0).astype(np.float32) for x in (reference, image))
    _, hdr, _ = flip_evaluator.evaluate(*radiance, "HDR")
    return colours, float(mean), float(hdr)


def row(picture: Picture, reference: Picture) -> tuple[np.ndarray, str]:
    """The map of FLIP, and one line of the table."""
    colours, mean, hdr = flip(picture.image, reference.image)
    _, noise, noise_hdr = flip(reference.first, reference.second)
    variance = sum(metrics.halves_variance(of.first, of.second) for of in (picture, reference))
    error = metrics.relative_mse(picture.image, reference.image, variance=variance)
    light = picture.image.mean() / reference.image.mean() - 1
    verdict = "ok" if mean <= AIM else "MISSED"
    return colours, (
        f"{mean:8.4f} {noise:8.4f} {hdr:10.4f} {noise_hdr:8.4f} {error:10.5f} {100 * light:+8.2f} %"
        f"  {verdict}"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.flip",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_arguments(parser)
    parser.add_argument("--spp", type=int, default=4096, help="samples per pixel of every picture")
    arguments = parser.parse_args()
    mi.set_variant(arguments.mode)
    lines = []
    for name in arguments.scenes:
        reference = converged(name, REFERENCE, arguments.spp, arguments)
        for method in arguments.weights:
            picture = converged(name, method, arguments.spp, arguments)
            colours, line = row(picture, reference)
            panels = side_by_side(shown(reference.image), shown(picture.image), colours)
            write_png(panels, arguments.folder / f"{name}-{Path(method).stem}-flip.png")
            lines.append(f"{name:12} {method:8} {line}")
    print(
        f"{'scene':12} {'networks':8} {'FLIP':>8} {'of noise':>8} {'HDR-FLIP':>10} {'of noise':>8} "
        f"{'rel. MSE':>10} {'light':>10}  aim: FLIP <= {AIM}"
    )
    print("\n".join(lines))


if __name__ == "__main__":
    main()
