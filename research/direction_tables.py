"""Errors in full tables of directions, the comparison of the Neural Material Adapter.

    python -m research.direction_tables --weights FILE --output out

Sharma et al. (2026) compare on 89 held-out stacks of three components (here: a rough interface, a
medium and a conductor, by Table 2) in tables over theta_i, phi_i, theta_o and phi_o, of 40 x 80 x
40 x 80 directions. Isotropic BRDFs need phi_i = 0 only: averages over all phi_i are the same, so
that a table has 40 x 40 x 80 values. Polar angles are at the cells' centres, azimuths at multiples
of 360/80 degrees. The publication leaves details open, which are fixed here: values are f without
cosine, PSNR's peak is the reference table's largest value, SMAPE is the mean of 2 |a - b| / (|a| +
|b|), and every measure is averaged over stacks. Compare only figures made by this code.

The walk simulates each distinct entry once (mirrored azimuths are equal, and so are exchanged
directions); the networks are evaluated at every entry.
"""

import json
import os
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import tyro
from benchmarks.evaluation import predict
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.distributions import Table2
from benchmarks.evaluation.samples import Group, Samples
from benchmarks.quality import pictures
from tqdm import tqdm

from urushi import checks, files
from urushi.core import error_metrics as metrics
from urushi.errors import FileError, ParameterError
from urushi.files import atomic_write, new_folder
from urushi.nets.weights import Model, Weights, find
from urushi.walk import StackTable, walk_pairs

_KIND = "direction table"


@dataclass(frozen=True)
class Protocol:
    """Size of the comparison.

    Attributes:
        stacks: number of stacks.
        polar, azimuth: numbers of angles; azimuth must be even.
        walks: number per simulated pair; at 1024 a value's standard error is about 1.5 %.
        seed: of stacks and walks.
    """

    stacks: int = 89
    polar: int = 40
    azimuth: int = 80
    walks: int = 1024
    seed: int = 0

    def __post_init__(self) -> None:
        if self.azimuth % 2 or min(self.polar, self.azimuth) < 1:
            raise ParameterError(
                f"the protocol has {self.polar} x {self.azimuth} angles; give positive numbers, "
                "the azimuths even"
            )

    def table(self) -> StackTable:
        """The stacks."""
        # The stacks depend on the group's name: another name would draw others.
        return sampling.draw_stacks(Group("adapter", Table2(1), self.stacks), self.seed)

    def directions(self) -> tuple[np.ndarray, np.ndarray]:
        """All entries' wi, wo: float32 (polar polar azimuth, 3), phi_i = 0."""
        theta = (np.arange(self.polar) + 0.5) * (0.5 * np.pi / self.polar)
        phi = np.arange(self.azimuth) * (2 * np.pi / self.azimuth)
        grid = np.broadcast_arrays(*np.ix_(theta, theta, phi))
        theta_i, theta_o, phi_o = (x.ravel() for x in grid)
        nothing = np.zeros_like(theta_i)
        wi = np.stack([np.sin(theta_i), nothing, np.cos(theta_i)], axis=-1)
        wo = np.stack(
            [np.sin(theta_o) * np.cos(phi_o), np.sin(theta_o) * np.sin(phi_o), np.cos(theta_o)],
            axis=-1,
        )
        return wi.astype(np.float32), wo.astype(np.float32)

    def distinct(self) -> tuple[np.ndarray, np.ndarray]:
        """Indices of one entry per class of equal entries, and the class of every entry."""
        shape = self.polar, self.polar, self.azimuth
        i, o, j = np.indices(shape)
        mirrored = np.minimum(j, self.azimuth - j)
        low, high = np.minimum(i, o), np.maximum(i, o)
        same = np.ravel_multi_index((low, high, mirrored), shape).ravel()
        return np.unique(same, return_inverse=True)


@dataclass(frozen=True)
class Outcome:
    """Averages over the stacks; an exact network would show those of the noise.

    Attributes:
        mae, psnr, smape: errors of the networks, the reference's noise included; psnr in dB.
        noise_mae, noise_psnr, noise_smape: expected errors from the reference's noise alone.
        evaluations: number of values evaluated by the networks.
        seconds: their time.
    """

    mae: float
    psnr: float
    smape: float
    noise_mae: float
    noise_psnr: float
    noise_smape: float
    evaluations: int
    seconds: float

    def text(self, protocol: Protocol) -> str:
        """The figures as lines of text."""
        rate = self.evaluations / max(self.seconds, 1e-9)
        full = protocol.azimuth * self.evaluations / rate
        return "\n".join(
            [
                f"{protocol.stacks} stacks, tables of {protocol.polar} x {protocol.azimuth} x "
                f"{protocol.polar} x {protocol.azimuth}, {protocol.walks} walks a pair",
                f"{'':<24}{'MAE':>10}{'PSNR [dB]':>12}{'SMAPE':>10}",
                f"{'networks':<24}{self.mae:>10.5f}{self.psnr:>12.2f}{self.smape:>10.4f}",
                f"{'the reference alone':<24}{self.noise_mae:>10.5f}{self.noise_psnr:>12.2f}"
                f"{self.noise_smape:>10.4f}",
                f"{rate / 1e6:.2f} M evaluations/s; all {protocol.azimuth} azimuths of wi would "
                f"take {full:.1f} s",
            ]
        )


def report(
    weights: Weights | None = None,
    output: str | os.PathLike | None = None,
    protocol: Protocol | None = None,
) -> str:
    """Compare networks by the protocol; returns the figures as text.

    Args:
        weights: the networks: a name of shipped ones, a weights file, or a Model; default: the
            default networks.
        output: folder for direction_tables.json and the simulated tables, which later calls reuse.
        protocol: the size; default: the publication's, whose simulation takes 10 to 20 minutes.

    Raises:
        FileError: the weights are missing or damaged, the folder's tables are damaged or of another
            size, or nothing can be written there.
    """
    protocol = protocol or Protocol()
    model = find(weights)
    folder = None if output is None else new_folder(output)
    tables = None if folder is None else new_folder(folder / "tables")
    outcome = measure(model, protocol, tables)
    if folder is not None:
        content = {"weights": model.fingerprint, **asdict(protocol), **asdict(outcome)}
        with atomic_write(folder / "direction_tables.json") as temporary:
            temporary.write_text(json.dumps(content, indent=2) + "\n")
    return outcome.text(protocol)


def measure(model: Model, protocol: Protocol, folder: str | os.PathLike | None = None) -> Outcome:
    """Compare networks with simulated tables, one stack at a time in memory.

    Args:
        model: the networks.
        protocol: the size.
        folder: for the simulated tables, which later calls reuse; default: they are not stored.

    Raises:
        FileError: the folder's tables are damaged, of another size, or cannot be written.
    """
    table, (wi, wo), (_, place) = protocol.table(), protocol.directions(), protocol.distinct()
    nothing = np.zeros((len(table), 0), np.float32)
    no_pairs = np.zeros((len(table), 0, 3), np.float32)
    materials = predict.materials(model, Samples(table, no_pairs, no_pairs, nothing, nothing))
    figures, seconds = [], 0.0
    with tqdm(total=len(table), desc="tables", unit="stack", disable=None) as progress:
        for material, (f, se) in zip(materials, _tables(protocol, table, folder), strict=True):
            start = time.perf_counter()
            f_hat = material.f(wi, wo)[:, 0]
            seconds += time.perf_counter() - start
            figures.append(_compare(f_hat, f[place], se[place]))
            progress.update()
    names = "mae", "psnr", "smape", "noise_mae", "noise_psnr", "noise_smape"
    mean = {name: float(x) for name, x in zip(names, np.mean(figures, axis=0), strict=True)}
    return Outcome(**mean, evaluations=len(wi) * len(table), seconds=seconds)


def _compare(f_hat: np.ndarray, f: np.ndarray, se: np.ndarray) -> tuple[float, ...]:
    """MAE, PSNR, SMAPE, and the expectations of the three for the reference's noise alone."""
    peak = float(f.max())
    noise = np.sqrt(2 / np.pi) * se.astype(np.float64)  # mean of |x| for a normal x
    power = float((se.astype(np.float64) ** 2).mean())
    return (
        pictures.mae(f_hat, f),
        metrics.psnr(f_hat, f, peak=peak),
        smape(f_hat, f),
        float(noise.mean()),
        float(10 * np.log10(peak**2 / power)) if power else np.inf,
        float((noise / np.maximum(f, 1e-12)).clip(max=2).mean()),
    )


def _tables(
    protocol: Protocol, table: StackTable, folder: str | os.PathLike | None
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Mean and standard error of every stack's distinct entries, kept in `folder` if given."""
    wi, wo = protocol.directions()
    entries, _ = protocol.distinct()
    for stack in range(len(table)):
        path = None if folder is None else Path(folder) / f"stack-{stack:03}.safetensors"
        if path is not None and path.exists():
            yield _stored(path, protocol, stack)
            continue
        row = np.full(len(entries), stack, np.uint32)
        # Streams are numbered within a request: each stack needs a seed of its own.
        seed = 1000 * protocol.seed + stack
        f, se = walk_pairs(table, row, wi[entries], wo[entries], walks=protocol.walks, seed=seed)
        if path is not None:
            arrays = {"f": f, "se": se.astype(np.float16)}
            files.write_tensors(path, _KIND, _description(protocol, stack), arrays)
        yield f, se


def _stored(path: Path, protocol: Protocol, stack: int) -> tuple[np.ndarray, np.ndarray]:
    description, arrays = files.read_tensors(path, _KIND)
    expected = _description(protocol, stack)
    if any(description.get(name) != value for name, value in expected.items()):
        raise FileError(f"'{path}' is a table of another protocol; choose another folder")
    return arrays["f"], arrays["se"].astype(np.float32)


def _description(protocol: Protocol, stack: int) -> dict[str, int]:
    return {
        "stack": stack,
        "polar": protocol.polar,
        "azimuth": protocol.azimuth,
        "walks": protocol.walks,
        "seed": protocol.seed,
    }


def main(weights: str | None = None, output: Path | None = None) -> None:
    """Compare networks on full direction tables of 89 stacks; takes 10 to 20 minutes.

    Args:
        weights: weights file of the networks; default: the shipped ones.
        output: folder for the figures and the simulated tables, which later calls reuse.
    """
    print(report(weights, output))


def smape(table: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    """Symmetric mean absolute percentage error as a fraction: mean of 2 |a - b| / (|a| + |b|).

    From 0 to 2; entries where both are zero count as exact.
    """
    table, reference = checks.finite(table=table, reference=reference)
    total = np.abs(table) + np.abs(reference)
    return float((2 * np.abs(table - reference) / np.where(total > 0, total, 1)).mean())


if __name__ == "__main__":
    tyro.cli(main)
