"""Comparison of encoded materials with their sources: figures, slices and spheres.

    python -m benchmarks.quality.examine SOURCE... -o FOLDER

Sources are those of `urushi encode`. Writes report.json, a table report.md, and a picture for every
source.
"""

import argparse
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.quality import sphere
from benchmarks.quality.pictures import BEST_PSNR
from matplotlib.figure import Figure

import urushi
from urushi.app.encode import Encode
from urushi.core import error_metrics as metrics
from urushi.core.direction_sets import cosine_pairs, half_angle_pairs
from urushi.core.error_metrics import energy_weight, pair_error
from urushi.core.quadrature import half_vector_rule
from urushi.errors import ParameterError, UrushiError
from urushi.files import atomic_write, new_folder
from urushi.material import Material
from urushi.material.source import Source, as_source
from urushi.material.symmetry import AZIMUTHS, RELATIVE_TOLERANCE, rotated_pairs
from urushi.material.values import evaluate_source
from urushi.measured import load_measured
from urushi.walk import Stack
from urushi.walk.simulate import simulate

#: Pairs for E and for P.
E_PAIRS, P_PAIRS = 4096, 2048

#: Angles [degrees] of light in the slices, and of the directional albedos.
INCIDENT, ALBEDO_ANGLES = (10.0, 45.0, 75.0), (0.0, 30.0, 60.0, 80.0)

#: Angles [degrees] of the slices' outgoing directions; the mirror direction has a positive one.
OUTGOING = np.linspace(-88.0, 88.0, 353)

#: Walks for each set of pairs of a Stack, which is simulated: the figures hold its noise.
WALKS = 1 << 23

#: Colours by number of channels.
COLOURS = {1: ("black",), 3: ("#d62728", "#2ca02c", "#1f77b4")}

#: Line styles of source and material.
SOURCE: dict[str, Any] = {"linewidth": 3.5, "alpha": 0.35}
MATERIAL: dict[str, Any] = {"linewidth": 1.0}

#: Values this far below a slice's largest are not shown.
RANGE = 1e-5


Brdf = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Examination:
    """A source and the material that it was encoded into, compared.

    Attributes:
        figures: of `examine`, as JSON values.
        slices: f [1/sr] of source and material in the plane of incidence, float32
            (2, `INCIDENT`, `OUTGOING`, C).
        pictures: a sphere of each in Urushi's studio, float32 (2, H, W, 3) of linear radiance.
    """

    figures: dict[str, Any]
    slices: np.ndarray
    pictures: np.ndarray


def examine(source: Any, material: Material) -> Examination:
    """Compare a source of `encode` with its material.

    The figures are, channel by channel, the errors E and the median of P against the source made
    isotropic and reciprocal, which is what was encoded, and directional albedos at `ALBEDO_ANGLES`;
    how much the averaging has changed, and what is left out
    (`urushi.material.symmetry.Deviations`); and how much the sphere's pictures differ. There and in
    the slices the source is only made isotropic. E is None where a channel is black.

    Raises:
        ParameterError: the material has neither one nor three channels, or as of `encode`.
    """
    if material.channels not in (1, 3):
        raise ParameterError(
            f"the material has {material.channels} channels; "
            "only those of one or three can be shown"
        )
    source = _opened(source)
    rng = np.random.default_rng(1)
    wi, wo = cosine_pairs(rng, E_PAIRS)
    widths = material.model.widths
    found = evaluate_source(source, wi, wo, widths=widths)
    truth, deviations = found.values, found.deviations
    weight = energy_weight(wi[:, 2], wo[:, 2])[:, None]
    energy = (truth * weight).sum(0, dtype=np.float64)
    error = (np.abs(material.f(wi, wo) - truth) * weight).sum(0, dtype=np.float64)
    wi, wo = half_angle_pairs(rng, P_PAIRS)
    p = pair_error(material.f(wi, wo), evaluate_source(source, wi, wo, widths=widths).values)
    averaged = widths == 1 and (deviations.anisotropy or 0.0) > RELATIVE_TOLERANCE
    isotropic = _isotropic(source, averaged)
    pictures = [sphere.studio(f) for f in (isotropic, material.f)]
    inside = sphere.mask()
    psnr = metrics.psnr(*(metrics.shown(picture)[inside] for picture in pictures[::-1]))
    figures = {
        "weights": material.model.fingerprint,
        "E": [float(a / b) if b > 0 else None for a, b in zip(error, energy, strict=True)],
        "P median": np.median(p, axis=0).tolist(),
        **deviations._asdict(),
        "albedo": {
            "angles [degrees]": list(ALBEDO_ANGLES),
            "source": _albedo(isotropic).tolist(),
            "material": _albedo(material.f).tolist(),
        },
        "sphere": {"psnr": min(psnr, BEST_PSNR)},
    }
    slices = np.stack(np.broadcast_arrays(_slices(isotropic), _slices(material.f)))
    return Examination(figures, slices, np.stack(pictures).astype(np.float32))


def mean_error(figures: Mapping[str, Any]) -> float | None:
    """Mean E of the channels that are not black, or None."""
    errors = [e for e in figures["E"] if e is not None]
    return float(np.mean(errors)) if errors else None


def _opened(source: Any) -> Source:
    if not isinstance(source, Stack):
        return as_source(source)
    return Source(
        lambda wi, wo: simulate(source, wi, wo, walks=max(WALKS // len(wi), 1), seed=0)[0],
        symmetric=True,
    )


def _isotropic(source: Source, anisotropic: bool) -> Brdf:
    """f(wi, wo) -> (N, C) of a source, averaged over the azimuth if that is needed."""

    def columns(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return np.asarray(source.f(wi, wo), np.float32).reshape(len(wi), -1)

    def mean(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return np.mean([columns(*pair) for pair in rotated_pairs(wi, wo, AZIMUTHS)], axis=0)

    return mean if anisotropic else columns


def _albedo(f: Brdf) -> np.ndarray:
    """Directional albedos (`ALBEDO_ANGLES`, C)."""
    wi = _in_plane(-np.array(ALBEDO_ANGLES))
    wo, weights = half_vector_rule(wi, anisotropic=True)
    count, nodes = weights.shape
    values = f(np.repeat(wi, nodes, axis=0), wo.reshape(-1, 3).astype(np.float32))
    return np.einsum("inc,in->ic", values.reshape(count, nodes, -1), weights * wo[..., 2])


def _slices(f: Brdf) -> np.ndarray:
    """f in the plane of incidence (`INCIDENT`, `OUTGOING`, C)."""
    count = len(INCIDENT), len(OUTGOING)
    wi = np.repeat(_in_plane(-np.array(INCIDENT)), count[1], axis=0)
    return f(wi, np.tile(_in_plane(OUTGOING), (count[0], 1))).reshape(*count, -1)


def _in_plane(degrees: np.ndarray) -> np.ndarray:
    """Unit vectors float32 (N, 3) in the xz plane, by signed angles from the normal."""
    angles = np.radians(degrees)
    return np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=-1).astype(np.float32)


def draw(path: str | os.PathLike, name: str, examination: Examination) -> None:
    """Draw an examination: f in the plane of incidence, albedos, and spheres.

    Raises:
        FileError: the file cannot be written.
    """
    figure = Figure(figsize=(11, 6.4), layout="constrained")
    upper, lower = figure.subplots(2, 3, height_ratios=(1, 1.1))
    largest = max(float(examination.slices.max()), 1e-6)
    for axis, incident, values in zip(
        upper, INCIDENT, np.moveaxis(examination.slices, 1, 0), strict=True
    ):
        _lines(axis, OUTGOING, np.maximum(values, largest * RANGE))
        axis.axvline(incident, color="grey", linewidth=0.5, linestyle="dotted")
        axis.set(yscale="log", ylim=(largest * RANGE, 2 * largest), xlim=(-90, 90))
        axis.set(title=f"light from {incident:g}°", xlabel="outgoing angle")
    upper[0].set_ylabel("f [1/sr]")
    _albedos(lower[0], examination)
    for axis, picture, title in zip(
        lower[1:], examination.pictures, ("source", "material"), strict=True
    ):
        axis.imshow(metrics.shown(picture), interpolation="lanczos")
        axis.set_axis_off()
        axis.set_title(title)
    figure.suptitle(_title(name, examination))
    with atomic_write(path) as temporary:
        figure.savefig(temporary, format="png", dpi=100)


def _albedos(axis: Any, examination: Examination) -> None:
    albedo = examination.figures["albedo"]
    values = np.stack(np.broadcast_arrays(albedo["source"], albedo["material"]))
    _lines(axis, np.array(ALBEDO_ANGLES), values, marker="o", markersize=3)
    axis.set(title="directional albedo", xlabel="angle of light", ylim=(0, None))
    for style, label in ((SOURCE, "source"), (MATERIAL, "material")):
        axis.plot([], [], color="black", label=label, **style)
    axis.legend()


def _lines(axis: Any, x: np.ndarray, values: np.ndarray, **style: Any) -> None:
    """Draw values (2, x, C) of source and material."""
    for rows, look in zip(values, (SOURCE, MATERIAL), strict=True):
        colours = COLOURS[rows.shape[-1]]
        for row, colour in zip(rows.T, colours, strict=True):
            axis.plot(x, row, color=colour, **(style | look))


def _title(name: str, examination: Examination) -> str:
    error = mean_error(examination.figures)
    parts = [name if error is None else f"{name}: E {error:.1%}"]
    parts.append(f"PSNR {examination.figures['sphere']['psnr']:.1f} dB")
    for key, words in (("anisotropy", "anisotropy"), ("reciprocity", "reciprocity error")):
        value = examination.figures[key]
        if value is not None and value >= 5e-4:
            parts.append(f"{words} {value:.1%}")
    return ", ".join(parts)


def write_report(folder: str | os.PathLike, examinations: Mapping[str, Examination]) -> None:
    """Write report.json, report.md and a picture NAME.png of each examination by name.

    Raises:
        FileError: a file cannot be written.
    """
    folder = new_folder(folder)
    for name, examination in examinations.items():
        draw(folder / f"{name}.png", name, examination)
    content = {name: e.figures for name, e in examinations.items()}
    with atomic_write(folder / "report.json") as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    with atomic_write(folder / "report.md") as temporary:
        temporary.write_text(_markdown(examinations), encoding="utf-8")


def _markdown(examinations: Mapping[str, Examination]) -> str:
    """A table of all examinations, followed by the pictures."""
    lines = [
        "# Encoded materials",
        "",
        "| | E, mean of channels | P, median | anisotropy | reciprocity error | PSNR of a sphere |",
        "|---|---|---|---|---|---|",
    ]
    for name, examination in examinations.items():
        figures = examination.figures
        cells = [
            _percent(mean_error(figures)),
            _percent(float(np.median(figures["P median"]))),
            _percent(figures["anisotropy"]),
            _percent(figures["reciprocity"]),
            f"{figures['sphere']['psnr']:.1f} dB",
        ]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    for name in examinations:
        lines += ["", f"![{name}](<{name}.png>)"]
    return "\n".join(lines) + "\n"


def _percent(share: float | None) -> str:
    return "unknown" if share is None else f"{share:.1%}"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("sources", nargs="+")
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args()
    encode = Encode(tuple(options.sources), options.output)
    examinations = {}
    for target, source in zip(encode.targets(), encode.opened(), strict=True):
        if isinstance(source, UrushiError):
            raise source
        opened = load_measured(source) if isinstance(source, Path) else source
        examinations[target.stem] = examine(opened, urushi.encode(opened))
    write_report(options.output, examinations)


if __name__ == "__main__":
    main()
