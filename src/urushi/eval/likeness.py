"""Pictures and reports that compare sources with their materials."""

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from urushi.eval import examine, metrics
from urushi.eval.examine import ALBEDO_ANGLES, INCIDENT, OUTGOING, Examination
from urushi.files import atomic_write, new_folder

#: Colours by number of channels.
COLOURS = {1: ("black",), 3: ("#d62728", "#2ca02c", "#1f77b4")}

#: Line styles of source and material.
SOURCE: dict[str, Any] = {"linewidth": 3.5, "alpha": 0.35}
MATERIAL: dict[str, Any] = {"linewidth": 1.0}

#: Values this far below a slice's largest are not shown.
RANGE = 1e-5


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


def _albedos(axis: Axes, examination: Examination) -> None:
    albedo = examination.figures["albedo"]
    values = np.stack(np.broadcast_arrays(albedo["source"], albedo["material"]))
    _lines(axis, np.array(ALBEDO_ANGLES), values, marker="o", markersize=3)
    axis.set(title="directional albedo", xlabel="angle of light", ylim=(0, None))
    for style, label in ((SOURCE, "source"), (MATERIAL, "material")):
        axis.plot([], [], color="black", label=label, **style)
    axis.legend()


def _lines(axis: Axes, x: np.ndarray, values: np.ndarray, **style: Any) -> None:
    """Draw values (2, x, C) of source and material."""
    for rows, look in zip(values, (SOURCE, MATERIAL), strict=True):
        colours = COLOURS[rows.shape[-1]]
        for row, colour in zip(rows.T, colours, strict=True):
            axis.plot(x, row, color=colour, **(style | look))


def _title(name: str, examination: Examination) -> str:
    error = examine.mean_error(examination.figures)
    parts = [name if error is None else f"{name}: E {error:.1%}"]
    parts.append(f"PSNR {examination.figures['sphere']['psnr']:.1f} dB")
    for key, words in (("anisotropy", "anisotropy"), ("reciprocity", "reciprocity error")):
        value = examination.figures[key]
        if value is not None and value >= 5e-4:
            parts.append(f"{words} {value:.1%}")
    return ", ".join(parts)


def write_report(
    folder: str | os.PathLike,
    examinations: Mapping[str, Examination],
    errors: Mapping[str, str] | None = None,
) -> None:
    """Write report.json, report.md and a picture of each examination.

    Args:
        folder: made if it is missing.
        examinations: by name; the picture is NAME.png.
        errors: sentences of sources that could not be encoded, by name.

    Raises:
        FileError: a file cannot be written.
    """

    folder, errors = new_folder(folder), errors or {}
    for name, examination in examinations.items():
        draw(folder / f"{name}.png", name, examination)
    content: dict[str, Any] = {name: e.figures for name, e in examinations.items()}
    content |= {name: {"error": error} for name, error in errors.items()}
    with atomic_write(folder / "report.json") as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    with atomic_write(folder / "report.md") as temporary:
        temporary.write_text(_markdown(examinations, errors), encoding="utf-8")


def _markdown(examinations: Mapping[str, Examination], errors: Mapping[str, str]) -> str:
    """A table of all examinations and errors, followed by the pictures."""
    lines = [
        "# Encoded materials",
        "",
        "| | E, mean of channels | P, median | anisotropy | reciprocity error | PSNR of a sphere |",
        "|---|---|---|---|---|---|",
    ]
    for name, examination in examinations.items():
        figures = examination.figures
        cells = [
            _percent(examine.mean_error(figures)),
            _percent(float(np.median(figures["P median"]))),
            _percent(figures["anisotropy"]),
            _percent(figures["reciprocity"]),
            f"{figures['sphere']['psnr']:.1f} dB",
        ]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    lines += [f"| {name} | {error} | | | | |" for name, error in errors.items()]
    for name in examinations:
        lines += ["", f"![{name}](<{name}.png>)"]
    return "\n".join(lines) + "\n"


def _percent(share: float | None) -> str:
    return "unknown" if share is None else f"{share:.1%}"
