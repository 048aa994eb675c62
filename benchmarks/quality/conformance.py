"""Errors of an implementation of OpenPBR: `python -m benchmarks.quality.conformance`.

Prints E and the error of the albedo, in per cent, of the plugin `openpbr`, or with `--values FILE`
of another renderer. The reference is one safetensors file: f of 40 coated materials by random walks
through the coat, at 300 pairs of directions. docs/conformance.md describes its format, and
`benchmarks.quality.openpbr_reference` makes it.
"""

import argparse
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import mitsuba as mi
import numpy as np

from urushi import files
from urushi.checks import finite
from urushi.core import error_metrics
from urushi.errors import FileError, ParameterError
from urushi.files import read_npz
from urushi.mitsuba.reading import probing
from urushi.openpbr_surface.description import openpbr

#: Number of pairs of directions, which have cosine density on both sides.
PAIRS = 300

KIND, VERSION = "conformance", 1
_REMEDY = "take the file that ships"

#: f(wi, wo) -> (N, 3) [1/sr].
Brdf = Callable[[np.ndarray, np.ndarray], np.ndarray]


class Reference(NamedTuple):
    """A file of reference values.

    Attributes:
        parameters: of the M materials, by their names.
        wi, wo: float32 (N, 3), unit vectors above the horizon, z the normal, x the tangent.
        f, se: float32 (M, N, 3) [1/sr], mean and standard error, linear sRGB, without cosine.
    """

    parameters: dict[str, dict[str, Any]]
    wi: np.ndarray
    wo: np.ndarray
    f: np.ndarray
    se: np.ndarray


class Errors(NamedTuple):
    """Errors of a renderer by material, float64 (M,).

    Attributes:
        error: E, a mean over channels (docs/conventions.md).
        albedo: relative error of the light reflected under even illumination; positive: too bright.
    """

    error: np.ndarray
    albedo: np.ndarray


def default_path() -> Path:
    return Path(__file__).with_name("openpbr_reference.safetensors")


def model(parameters: Mapping[str, Any], *, walks: int = 0) -> Brdf:
    """f of the plugin `openpbr` with a material's parameters.

    walks: for a pair, through the coat; 0: its networks.

    Raises:
        PlatformError: no variant of Mitsuba is set.
    """
    bsdf = openpbr(reference=walks > 0, **parameters).bsdf()
    numbers = [float(k) for k in range(max(walks, 1))]
    return lambda wi, wo: np.mean([bsdf_values(bsdf, wi, wo, k) for k in numbers], axis=0)


def evaluated(build: Callable[[dict[str, Any]], Brdf], reference: Reference) -> np.ndarray:
    """f (M, N, 3) of an implementation, a function such as `model`, at the reference's pairs."""
    wi, wo = reference.wi, reference.wo
    return np.stack([build(parameters)(wi, wo) for parameters in reference.parameters.values()])


def bsdf_values(bsdf: Any, wi: np.ndarray, wo: np.ndarray, number: Any = 0.0) -> np.ndarray:
    """f (N, 3); walks of the same pair differ by their number, one or (N,)."""
    return probing.bsdf_values(bsdf, wi, wo, np.full((len(wi), 2), 0.5), number)


def read(path: str | os.PathLike | None = None) -> Reference:
    """Read a file; default: the one that ships.

    Raises:
        FileError: missing, foreign, damaged, or of another version.
    """
    path = default_path() if path is None else path
    description, arrays = files.read_tensors(path, KIND)
    if description.get("version") != VERSION:
        raise FileError(f"'{path}' is of version {description.get('version')}; {_REMEDY}")
    materials = {entry["name"]: entry["parameters"] for entry in description["materials"]}
    shapes: dict[str, tuple[int, ...]] = {"wi": (PAIRS, 3), "wo": (PAIRS, 3)}
    shapes |= {name: (len(materials), PAIRS, 3) for name in ("f", "se")}
    if any(name not in arrays or arrays[name].shape != shape for name, shape in shapes.items()):
        raise FileError(f"'{path}' lacks values of its materials; {_REMEDY}")
    return Reference(materials, *(arrays[name] for name in ("wi", "wo", "f", "se")))


def errors(values: np.ndarray, reference: Reference) -> Errors:
    """Errors of values (M, N, 3) [1/sr] of a renderer for the materials and pairs of a file.

    Raises:
        ParameterError: the shape is another one, or a value is not finite.
    """
    (values,) = finite(f=values)
    if values.shape != reference.f.shape:
        raise ParameterError(
            f"f has the shape {values.shape}; give one of {reference.f.shape}: materials, pairs "
            "and channels of the reference"
        )
    wi, wo = reference.wi, reference.wo
    e = [channel_errors(v, f, wi, wo).mean() for v, f in zip(values, reference.f, strict=True)]
    # Pairs have cosine density on both sides, so that albedos are plain means.
    albedo = values.mean(1) / reference.f.mean(1, dtype=np.float64) - 1
    return Errors(np.array(e), albedo.mean(1))


def noise(reference: Reference) -> np.ndarray:
    """E (M,) of a normal error of the standard error, whose mean size is 0.8 of its deviation."""
    return errors(reference.f + np.sqrt(2 / np.pi) * reference.se, reference).error


def channel_errors(values: np.ndarray, f: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """E of each channel (3,), of values (N, 3)."""
    return error_metrics.stack_error(values.T, f.T, wi[:, 2], wo[:, 2])


def table(reference: Reference, results: Mapping[str, Errors]) -> str:
    """The errors as text: one line for each material, then mean and 95th percentile."""
    own = 100 * noise(reference)
    error, albedo = (
        np.array([100 * getattr(r, name) for r in results.values()]) for name in ("error", "albedo")
    )
    heads = "".join(f"{name:>16}" for name in results)
    lines = [
        "E and error of the albedo [%], against random walks",
        f"{'':30}{heads}{'noise':>8}",
    ]
    for k, name in enumerate(reference.parameters):
        lines.append(f"{name:30}{_cells(error[:, k], albedo[:, k], '+')}{own[k]:8.2f}")
    albedo = np.abs(albedo)
    lines.append(f"{'mean':30}{_cells(error.mean(1), albedo.mean(1))}{own.mean():8.2f}")
    highs = (np.percentile(x, 95, axis=1) for x in (error, albedo))
    return "\n".join([*lines, f"{'95th percentile':30}{_cells(*highs)}"])


def _cells(errors: np.ndarray, albedos: np.ndarray, sign: str = "") -> str:
    return "".join(f"{e:8.2f}{a:{sign}8.1f}" for e, a in zip(errors, albedos, strict=True))


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--values", type=Path, help="NPZ file of a renderer: f of (40, 300, 3)")
    parser.add_argument("--reference", type=Path, help="default: the file of the repository")
    options = parser.parse_args(arguments)
    reference = read(options.reference)
    if options.values is None:
        mi.set_variant("llvm_ad_rgb")
        name, f = "urushi", evaluated(model, reference)
    else:
        name, (f,) = options.values.stem, read_npz(options.values, "f")
    print(table(reference, {name: errors(f, reference)}))


if __name__ == "__main__":
    main()
