"""Comparison of encoded materials with their sources: a table, slices of f and spheres.

    python -m benchmarks.examine SOURCE... -o FOLDER

Sources are those of `urushi encode`. Prints a table, and writes a picture for every source. E and
the median of P are against the source made isotropic and reciprocal, which is what was encoded; in
the slices, albedos and spheres it is only made isotropic.
"""

import functools
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro
from benchmarks import measures, sphere
from benchmarks.measures import Brdf, error, half_angle_pairs, in_plane
from benchmarks.pictures import psnr
from benchmarks.showing import figure as empty
from benchmarks.showing import percent, table

import urushi
from urushi.app.encode import Encode, opened, scene_bsdfs
from urushi.core import error_metrics as metrics
from urushi.core.direction_sets import cosine_pairs
from urushi.core.quadrature import directional_albedos
from urushi.files import atomic_write, new_folder
from urushi.material import Material
from urushi.material.source import Source, as_source
from urushi.material.symmetry import AZIMUTHS, RELATIVE_TOLERANCE, rotated_pairs
from urushi.material.values import evaluate_source
from urushi.walk import Stack
from urushi.walk.simulate import simulate

#: Pairs for E and for P; walks for each set of pairs of a stack, whose noise figures hold.
E_PAIRS, P_PAIRS, WALKS = 4096, 2048, 1 << 23
#: Angles [degrees] of light in the slices, and of the directional albedos.
INCIDENT, ALBEDO_ANGLES = (10.0, 45.0, 75.0), (0.0, 30.0, 60.0, 80.0)
#: Angles [degrees] of the slices' outgoing directions; the mirror direction has a positive one.
OUTGOING = np.linspace(-88.0, 88.0, 353)
#: Colours by number of channels; line styles of source and material.
COLOURS = {1: ("black",), 3: ("#d62728", "#2ca02c", "#1f77b4")}
STYLES = {
    "source": {"linewidth": 3.5, "alpha": 0.35},
    "material": {"linewidth": 1.0, "alpha": 1.0},
}
#: Values this far below a slice's largest are not shown.
RANGE = 1e-5


def examine(path: Path, name: str, source: Any, material: Material) -> dict[str, float | None]:
    """Compare a source of `encode` with its material of one or three channels, and draw both.

    Returns E, the median of P, `anisotropy` and `reciprocity` (how much the averaging has changed,
    see `urushi.material.symmetry.Deviations`), and the PSNR of a sphere in Urushi's studio.
    """
    source, rng, widths = _opened(source), np.random.default_rng(1), material.model.widths
    wi, wo = cosine_pairs(rng, E_PAIRS)
    values, deviations = evaluate_source(source, wi, wo, widths=widths)
    e = error(material.f(wi, wo), values, wi, wo)
    wi, wo = half_angle_pairs(rng, P_PAIRS)
    truth, _ = evaluate_source(source, wi, wo, widths=widths)
    averaged = widths == 1 and (deviations.anisotropy or 0.0) > RELATIVE_TOLERANCE
    both = _isotropic(source, AZIMUTHS if averaged else 1), material.f
    pictures = [sphere.studio(f) for f in both]
    figures = {
        "E": e,
        "P": float(np.median(measures.pair_error(material.f(wi, wo), truth))),
        "anisotropy": deviations.anisotropy,
        "reciprocity": deviations.reciprocity,
        "PSNR": psnr(pictures[1], pictures[0], sphere.mask()),
    }
    lit = in_plane(-np.radians(ALBEDO_ANGLES))
    count = len(INCIDENT), len(OUTGOING)
    plane = np.repeat(in_plane(-np.radians(INCIDENT)), count[1], axis=0)
    leaving = np.tile(in_plane(np.radians(OUTGOING)), (count[0], 1))
    parts = (
        [f(plane, leaving).reshape(*count, -1) for f in both],
        [directional_albedos(f, lit, anisotropic=True) for f in both],
    )
    slices, shares = (np.stack(np.broadcast_arrays(*part)) for part in parts)
    draw(path, f"{name}: E {percent(e)}, PSNR {figures['PSNR']:.1f} dB", slices, shares, pictures)
    return figures


def _opened(source: Any) -> Source:
    if not isinstance(source, Stack):
        return as_source(source)
    return Source(
        lambda wi, wo: simulate(source, wi, wo, walks=max(WALKS // len(wi), 1), seed=0)[0],
        symmetric=True,
    )


def _isotropic(source: Source, azimuths: int) -> Brdf:
    """f(wi, wo) -> (N, C) of a source, averaged over a number of azimuths."""

    def f(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        pairs = rotated_pairs(wi, wo, azimuths)
        values = [np.asarray(source.f(*pair), np.float32) for pair in pairs]
        return np.mean(values, axis=0).reshape(len(wi), -1)

    return f


def draw(
    path: Path, title: str, slices: np.ndarray, albedo: np.ndarray, pictures: list[np.ndarray]
) -> None:
    """Draw source and material: f in the plane of incidence, albedos, and spheres.

    slices: (2, `INCIDENT`, `OUTGOING`, C) [1/sr]; albedo: (2, `ALBEDO_ANGLES`, C).
    """
    figure = empty(11, 6.4)
    upper, (shares, *spheres) = figure.subplots(2, 3, height_ratios=(1, 1.1))
    largest = max(float(slices.max()), 1e-6)
    for axis, incident, values in zip(upper, INCIDENT, np.moveaxis(slices, 1, 0), strict=True):
        _lines(axis, OUTGOING, np.maximum(values, largest * RANGE))
        axis.axvline(incident, color="grey", linewidth=0.5, linestyle="dotted")
        axis.set(yscale="log", ylim=(largest * RANGE, 2 * largest), xlim=(-90, 90))
        axis.set(title=f"light from {incident:g}°", xlabel="outgoing angle")
    upper[0].set_ylabel("f [1/sr]")
    _lines(shares, np.array(ALBEDO_ANGLES), albedo)
    shares.set(title="directional albedo", xlabel="angle of light", ylim=(0, None))
    for label, style in STYLES.items():
        shares.plot([], [], color="black", label=label, **style)
    shares.legend()
    for axis, picture, label in zip(spheres, pictures, STYLES, strict=True):
        axis.imshow(metrics.shown(picture), interpolation="lanczos")
        axis.set_axis_off()
        axis.set_title(label)
    figure.suptitle(title)
    with atomic_write(path) as temporary:
        figure.savefig(temporary, format="png", dpi=100)


def _lines(axis: Any, x: np.ndarray, values: np.ndarray) -> None:
    """Draw values (2, x, C) of source and material."""
    for rows, style in zip(values, STYLES.values(), strict=True):
        for row, colour in zip(rows.T, COLOURS[rows.shape[-1]], strict=True):
            axis.plot(x, row, color=colour, **style)


def main(
    sources: tyro.conf.Positional[tuple[str, ...]],
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])],
) -> None:
    """Print the table and write the pictures into the folder `output`."""
    bsdfs = functools.cache(scene_bsdfs)
    targets, rows = Encode(sources, output).targets(), []
    opened_sources = [opened(text, bsdfs) for text in sources]
    folder = new_folder(output)
    for target, source in zip(targets, opened_sources, strict=True):
        figures = examine(folder / f"{target.stem}.png", target.stem, source, urushi.encode(source))
        shares = [percent(figures[k]) for k in ("E", "P", "anisotropy", "reciprocity")]
        rows.append([target.stem, *shares, f"{figures['PSNR']:.1f} dB"])
    head = ["source", "E", "P, median", "anisotropy", "reciprocity error", "PSNR of a sphere"]
    print(table(head, rows))


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
