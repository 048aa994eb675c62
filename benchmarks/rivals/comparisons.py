"""Methods that represent a measured BRDF, and their errors, for `benchmarks.quality.measured`."""

import hashlib
import inspect
import json
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from benchmarks.quality import pictures, sphere
from benchmarks.quality.sphere import Environment
from benchmarks.rivals import ggx_fit, nbrdf

import urushi
from urushi.core import direction_sets, error_metrics, table
from urushi.core import error_metrics as metrics
from urushi.files import atomic_write
from urushi.material import energy
from urushi.measured import Merl, load_measured
from urushi.measured.merl import SHAPE
from urushi.measured.tabulated import bin_centres
from urushi.nets import code_fit
from urushi.nets.weights import find

#: The methods, in the order of the columns.
METHODS = ("code", "table", "GGX", "two GGX", "NBRDF", "Mitsuba")

#: Pairs of directions of E.
PAIRS = 4096

#: f(wi, wo) -> (N, 3) [1/sr].
Brdf = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Reciprocal:
    """A BRDF averaged over the exchange of wi and wo.

    RGL files are only as reciprocal as their measurement; most methods are exactly reciprocal, and
    an error that none of them can avoid would hide their differences.
    """

    source: Any

    def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """(N, 3) [1/sr] of unit vectors (N, 3)."""
        return 0.5 * (self.source.f(wi, wo) + self.source.f(wo, wi))


@dataclass(frozen=True)
class Measured:
    """A measured material.

    Attributes:
        name: name of the material, unique in its set.
        path: a MERL or RGL file, or an archive (.npz) of networks of 675 weights by name. The table
            of the network `name` in MERL's bins stands in for a measured file.
    """

    name: str
    path: Path

    def load(self) -> Merl | Reciprocal:
        """The BRDF, made reciprocal."""
        if self.path.suffix != ".npz":
            source = load_measured(self.path)
            return source if isinstance(source, Merl) else Reciprocal(source)
        with np.load(self.path) as archive:
            weights = archive[self.name].astype(np.float64)
        angles = (a.ravel() for a in np.broadcast_arrays(*bin_centres(SHAPE)))
        table = np.maximum(np.expm1(nbrdf.logits(weights, nbrdf.vectors(*angles))), 0)
        return Merl(table.reshape(*SHAPE, 3))

    @property
    def is_rgl(self) -> bool:
        """Whether Mitsuba's `measured` can read it."""
        return self.path.suffix == ".bsdf"

    def digest(self) -> bytes:
        """A hash of the material's content and name."""
        content = self.path.read_bytes() + inspect.getsource(Reciprocal).encode()
        return hashlib.sha256(content + self.name.encode()).digest()


@dataclass(frozen=True)
class Result:
    """Errors and cost of a method for a material.

    Attributes:
        look: errors of the spheres, means over environments.
        error: E, the mean over channels that are not black.
        seconds: CPU time to encode, fit or train [s].
    """

    look: pictures.Comparison
    error: float
    seconds: float


@dataclass(frozen=True)
class Comparisons:
    """Settings of all comparisons, and their stored results.

    Attributes:
        environments: environments with their exposure.
        weights: Urushi's networks, in the form that `urushi.encode` accepts.
        folder: folder of stored results.
        code: for each method, a hash of the code and networks that its results depend on, taken
            once at the start.
    """

    environments: list[Environment]
    weights: str | None
    folder: Path
    code: dict[str, str]

    def run(self, material: Measured, names: list[str]) -> None:
        """Compute and store the results that are missing."""
        missing = [name for name in names if not self.file(material, name).is_file()]
        if not missing:
            return
        reference = Reference(material.load(), self.environments)
        for name in missing:
            result = self._run(material, name, reference)
            content = {"E": result.error, "seconds": result.seconds, **result.look.as_dict()}
            with atomic_write(self.file(material, name)) as temporary:
                temporary.write_text(json.dumps(content) + "\n")

    def result(self, material: Measured, name: str) -> Result:
        """A stored result."""
        content = json.loads(self.file(material, name).read_text())
        error, seconds = content.pop("E"), content.pop("seconds")
        return Result(pictures.Comparison(**content), error, seconds)

    def file(self, material: Measured, name: str) -> Path:
        """The file of a result; its name has a hash of everything that the result depends on."""
        digest = hashlib.sha256(material.digest())
        for environment in self.environments:
            digest.update(environment.radiance.tobytes())
        digest.update(self.code[name].encode())
        label = name.replace(" ", "-")
        return self.folder / f"{material.name}.{label}.{digest.hexdigest()[:16]}.json"

    def _run(self, material: Measured, name: str, reference: "Reference") -> Result:
        start = time.process_time()
        if name == "code":
            f = urushi.encode(reference.truth, self.weights, table=False).f
        elif name == "table":
            f = urushi.encode(reference.truth, self.weights, table=True).f
        elif name == "NBRDF":
            f = nbrdf.train(reference.truth.f).f
        elif name == "Mitsuba":
            f = _mitsuba(material.path)
        else:
            return reference.best(ggx_fit.candidates(reference.truth.f, 1 if name == "GGX" else 2))
        seconds = time.process_time() - start
        return Result(reference.look(f), reference.error(f), seconds)


class Reference:
    """A measured BRDF, its pictures and values, with which others are compared."""

    def __init__(self, truth: Merl | Reciprocal, environments: list[Environment]) -> None:
        self.truth = truth
        self._environments = environments
        self._pictures = sphere.render(truth.f, environments)
        self._wi, self._wo = direction_sets.cosine_pairs(np.random.default_rng(1), PAIRS)
        self._values = truth.f(self._wi, self._wo)

    def look(self, f: Brdf) -> pictures.Comparison:
        """Errors of the pictures of spheres, means over environments."""
        found = sphere.render(f, self._environments)
        both = zip(found, self._pictures, strict=True)
        return pictures.Comparison.mean([pictures.compare(*pair, sphere.mask()) for pair in both])

    def error(self, f: Brdf) -> float:
        """E, the mean over channels."""
        values, f_hat = self._values.T, f(self._wi, self._wo).T
        lit = values.max(axis=1) > 0
        cosines = self._wi[:, 2], self._wo[:, 2]
        return float(error_metrics.stack_error(f_hat[lit], values[lit], *cosines).mean())

    def best(self, candidates: Iterator[ggx_fit.GgxFit]) -> Result:
        """The result of the fit of highest mean PSNR of spheres, with the time of all fits."""
        start = time.process_time()
        fits = list(candidates)
        seconds = time.process_time() - start
        looks = [self.look(fit.f) for fit in fits]
        place = int(np.argmax([look.psnr for look in looks]))
        return Result(looks[place], self.error(fits[place].f), seconds)


def code_hashes(names: list[str], weights: str | None) -> dict[str, str]:
    """For each method, a hash of the modules that its results depend on most, and of networks."""
    modules: dict[str, list[ModuleType]] = {
        "code": [energy, code_fit],
        "table": [energy, code_fit, table],
        "GGX": [ggx_fit],
        "two GGX": [ggx_fit],
        "NBRDF": [nbrdf],
        "Mitsuba": [],
    }
    result = {}
    for name in names:
        digest = hashlib.sha256()
        for module in (sphere, metrics, *modules[name]):
            digest.update(inspect.getsource(module).encode())
        if name in ("code", "table"):
            digest.update(find(weights).fingerprint.encode())
        result[name] = digest.hexdigest()
    return result


def _mitsuba(path: Path) -> Brdf:
    """Mitsuba's own plugin on an RGL file."""
    import mitsuba as mi

    from urushi.mitsuba.reading import probing

    mi.set_variant("llvm_ad_rgb")
    bsdf = mi.load_dict({"type": "measured", "filename": str(path)})
    return lambda wi, wo: probing.bsdf_values(bsdf, wi, wo, np.full((len(wi), 2), 0.5, np.float32))
