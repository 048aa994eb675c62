"""Experiments: cases that are measured, kept in files, shown as tables and drawn.

Every module of `benchmarks.experiments` has one, `EXPERIMENT`, of the module's name. Results of a
whole run with the shipped weights are stored as figures/NAME.json, with the date, the processor and
the fingerprints of the weights, and drawn as figures/NAME.png. Their tables are written into pages
of the documentation: a table is found there by its first line, and its source by the sentence
"Source: `python -m benchmarks NAME`". Other sentences are not: read them again when numbers change.
"""

import hashlib
import importlib
import json
import os
import platform
import re
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.showing import DPI, table
from matplotlib.figure import Figure
from tqdm import tqdm

from urushi.core import error_metrics as metrics
from urushi.files import atomic_write
from urushi.nets.weights import Model, anisotropic_model, default_model, find

ROOT = Path(__file__).parents[1]
FIGURES, PARTS = ROOT / "figures", Path("out/figures")
RESULTS = ROOT / "docs" / "results.md"
#: The sentence on the page of results that names those of other weights.
STALE = re.compile(r"Stale results: .*?\.(?=\n\n|\n?\Z)", re.DOTALL)

Found = dict[str, Any]
#: From a case's name to its pictures by name, as sRGB values in [0, 1].
Pictures = Callable[[str], dict[str, np.ndarray]]


@dataclass(frozen=True)
class Options:
    """What a run may change.

    Attributes:
        weights: networks, a name or a file; None: the shipped ones.
        files: MERL or RGL files, folders of these, or archives of neural fits; by default those in
            the folder that URUSHI_TEST_DATA names.
        share: of samples, walks, stacks and texels; below 1 a run is quicker and less certain.
    """

    weights: str | None = None
    files: tuple[Path, ...] = ()
    share: float = 1.0

    @property
    def model(self) -> Model:
        return find(self.weights)

    def count(self, number: float, least: int = 1) -> int:
        """A share of a number of samples and the like."""
        return max(least, round(self.share * number))

    def data(self) -> tuple[Path, ...]:
        """The measured files; none if neither `files` nor the variable names them."""
        folder = Path(os.environ.get("URUSHI_TEST_DATA", "")) / "data"
        known = (folder / "rgl", *sorted((folder / "merl_nbrdf").glob("*.npz")))
        return self.files or tuple(path for path in known if path.exists())


@dataclass(frozen=True)
class Experiment:
    """A measurement.

    Attributes:
        cases: from options to the cases by name.
        measure: (case, options) -> values by name, in lists and arrays, or these and pictures
            (..., H, W, 3) of linear radiance by name, in a tuple; by default the case is this
            function of the options. Finished cases are kept, and are not measured again. Floats are
            kept to five significant digits, so that committed files are small.
        tables: from values by case to tables in Markdown; a case may be missing.
        plot: (values by case, pictures by case) -> figure, if there is one.
        pages: of the tables, relative to the repository.
        models: weights that results depend on, by name.
        minutes: on two cores of an AMD EPYC.
    """

    cases: Callable[[Options], Mapping[str, Any]]
    tables: Callable[[Found], list[str]]
    measure: Callable[[Any, Options], Any] = lambda case, options: case(options)
    plot: Callable[[Found, Pictures], Figure] | None = None
    pages: tuple[str, ...] = ("docs/results.md",)
    models: Mapping[str, Callable[[], Any]] = field(default_factory=dict)
    minutes: float = 1


NETWORKS = {"weights": default_model}
BOTH = NETWORKS | {"anisotropic weights": anisotropic_model}


def names() -> list[str]:
    """All experiments."""
    return sorted(path.stem for path in (Path(__file__).parent / "experiments").glob("[a-z]*.py"))


def load(name: str) -> Experiment:
    return importlib.import_module(f"benchmarks.experiments.{name}").EXPERIMENT


def run(name: str, options: Options, chosen: Sequence[str] = (), fresh: bool = False) -> Found:
    """Measure the cases that are missing, store what is complete, and draw it.

    Without cases, it says why in a sentence and returns nothing.

    Args:
        name: of the experiment.
        options: of the run.
        chosen: names of cases; default: all, whose results are stored if the options are the
            default ones.
        fresh: measure cases again that were measured before.
    """
    experiment = load(name)
    key = hashlib.sha256(repr((options.model.fingerprint, options)).encode()).hexdigest()[:12]
    known, folder = experiment.cases(options), PARTS / f"{name}-{key}"
    cases = {k: c for k, c in known.items() if not chosen or k in chosen}
    if not cases:
        reason = "it measures files, and found none; give --files, or set URUSHI_TEST_DATA"
        if known:
            reason = f"it knows none of {', '.join(chosen)}; choose from {', '.join(known)}"
        print(f"{name} has no cases: {reason}")
        return {}

    def file(case: str, suffix: str) -> Path:
        return folder / (re.sub(r"[^\w.-]+", "_", case) + suffix)

    def pictures(case: str) -> dict[str, np.ndarray]:
        with np.load(file(case, ".npz")) as kept:
            return {name: metrics.shown(kept[name].astype(np.float32)) for name in kept}

    found: Found = {}
    for key, case in tqdm(cases.items(), desc=name, unit="case", disable=None):
        path = file(key, ".json")
        if fresh or not path.is_file():
            measured = experiment.measure(case, options)
            values, images = measured if isinstance(measured, tuple) else (measured, None)
            folder.mkdir(parents=True, exist_ok=True)
            if images is not None:
                with atomic_write(file(key, ".npz")) as temporary:
                    np.savez(temporary, **{k: np.float16(v) for k, v in images.items()})
            _write_json(path, rounded(values))
        found[key] = json.loads(path.read_text())
    if not chosen and replace(options, files=()) == Options():
        stamp = {"date": date.today().isoformat(), "processor": processor()}
        models = {key: model().fingerprint for key, model in experiment.models.items()}
        _write_json(FIGURES / f"{name}.json", {**stamp, "weights": models, "cases": found})
        if experiment.plot is not None:
            figure = experiment.plot(found, pictures)
            with atomic_write(FIGURES / f"{name}.png") as temporary:
                figure.savefig(temporary, format="png", dpi=DPI)
    return found


def kept(name: str, compute: Callable[[], Iterable[np.ndarray]]) -> list[np.ndarray]:
    """Arrays that are computed once, and then read from out/figures/NAME.npz."""
    path = PARTS / f"{name}.npz"
    if not path.is_file():
        arrays = compute()
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_write(path) as temporary:
            np.savez(temporary, *arrays)
    with np.load(path) as stored:
        return [stored[name] for name in stored.files]


def rounded(values: Any, digits: int = 5) -> Any:
    """Values for JSON: few digits of floats, and lists in the place of arrays."""
    if isinstance(values, (np.ndarray, np.generic)):
        values = values.tolist()
    if isinstance(values, Mapping):
        return {name: rounded(value, digits) for name, value in values.items()}
    if isinstance(values, (list, tuple)):
        return [rounded(value, digits) for value in values]
    return float(f"{values:.{digits}g}") if isinstance(values, float) else values


def _write_json(path: Path, values: Any) -> None:
    with atomic_write(path) as temporary:
        temporary.write_text(json.dumps(values, indent=1) + "\n")


def processor() -> str:
    """The name of this machine's processor."""
    text = Path("/proc/cpuinfo").read_text("utf-8")
    found = re.search(r"^model name\s*: (.*)", text, re.MULTILINE)
    return found[1] if found else platform.machine()


def stored(name: str) -> Found | None:
    """The stored results of an experiment: date, processor, weights, and values by case."""
    path = FIGURES / f"{name}.json"
    return json.loads(path.read_text()) if path.is_file() else None


def state(name: str) -> str:
    """Whether results are stored, and by weights that are not the shipped ones."""
    found = stored(name)
    if found is None:
        return "none stored"
    now = {key: model().fingerprint for key, model in load(name).models.items()}
    return "" if now == found["weights"] else "stale"


def states() -> str:
    """A table of all experiments: date of the stored results, and which are stale."""
    dates = {name: (stored(name) or {"date": ""})["date"] for name in names()}
    rows = [[f"`{k}`", day, f"{load(k).minutes:g}", state(k)] for k, day in dates.items()]
    return table(["results", "date", "minutes", "state"], rows)


def stale() -> str:
    """The sentence that names the experiments without results of the shipped weights."""
    found = [f"`{name}`" for name in names() if state(name)]
    return textwrap.fill(f"Stale results: {', '.join(found) or 'none'}.", 100)


def source(name: str) -> str:
    """The sentence that states how stored results were made."""
    found = stored(name)
    assert found is not None
    parts = [f"Source: `python -m benchmarks {name}`", found["date"], found["processor"]]
    parts += [f"{key} {value}" for key, value in found["weights"].items()]
    return textwrap.fill("; ".join(parts) + ".", 100, break_on_hyphens=False)


def shown() -> dict[Path, str]:
    """The texts of all pages with the tables and sources of the stored results, and the stale ones.

    Raises:
        ValueError: a table is on no page, or twice on one; or no sentence names the stale results.
    """
    text, sentences = STALE.subn(lambda _: stale(), RESULTS.read_text())
    if sentences != 1:
        raise ValueError(f"{RESULTS.name} has {sentences} sentences that begin 'Stale results: '")
    texts: dict[Path, str] = {RESULTS: text}
    for name in names():
        found, experiment = stored(name), load(name)
        if found is None:
            continue
        pages, sentence = [ROOT / page for page in experiment.pages], source(name)
        old = re.compile(rf"Source: `python -m benchmarks {name}`;.*?\.(?=\n\n|\n?\Z)", re.DOTALL)
        for page in pages:
            text = texts.get(page) or page.read_text()
            texts[page] = old.sub(lambda _, new=sentence: new, text)
        for new in experiment.tables(found["cases"]):
            head = new.partition("\n")[0]
            having = [page for page in pages if head in texts[page].split("\n")]
            if not having:
                raise ValueError(f"no page of {name} has a table that begins '{head}'; add it")
            for page in having:
                texts[page] = replaced(texts[page], new)
    return texts


def replaced(text: str, new: str) -> str:
    """A page's text with the table whose first line is that of a new one replaced by it.

    Raises:
        ValueError: the page has no such table, or more than one.
    """
    head = re.escape(new.partition("\n")[0])
    text, count = re.subn(rf"^{head}$(\n\|.*)*", lambda _: new, text, flags=re.MULTILINE)
    if count != 1:
        raise ValueError(f"the page has {count} tables with the first line '{head}'")
    return text
