"""Measures experiments, stores and draws their results, and writes their tables into the docs.

Without names, lists all experiments and says whose stored results are stale. `all` runs every one
of them, which takes a night, and `stale` those that have no results of the shipped weights. `pages`
writes the tables of stored results only. A run that is stopped continues with finished cases, which
are kept in out/figures.
"""

import argparse
import importlib
from pathlib import Path

import mitsuba as mi
from benchmarks import experiment
from benchmarks.experiment import Options

from urushi.files import atomic_write


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", help="experiments, all, stale, or pages")
    parser.add_argument(
        "--cases", nargs="+", default=(), help="only these cases; nothing is stored"
    )
    parser.add_argument("--weights", help="networks: a name or a file")
    parser.add_argument("--files", nargs="+", default=(), type=Path, help="measured materials")
    parser.add_argument("--share", type=float, default=1.0, help="of samples, walks and stacks")
    parser.add_argument("--variant", default=Options.variant, help="of Mitsuba")
    parser.add_argument("--fresh", action="store_true", help="measure finished cases again")
    given = parser.parse_args()
    known = experiment.names()
    wrong = [name for name in given.names if name not in (*known, "all", "stale", "pages")]
    if wrong:
        parser.error(f"there is no experiment '{wrong[0]}'; choose from {', '.join(known)}")
    options = Options(given.weights, tuple(given.files), given.share, given.variant)
    mi.set_variant(options.variant)
    chosen = [
        name
        for name in known
        if name in given.names
        or "all" in given.names
        or ("stale" in given.names and experiment.state(name))
    ]
    for name in chosen:
        found = experiment.run(name, options, given.cases, given.fresh)
        if not found:
            continue  # it said why
        module = importlib.import_module(f"benchmarks.experiments.{name}")
        print(f"\n{name}: {(module.__doc__ or '').splitlines()[0]}\n")
        print("\n\n".join(experiment.load(name).tables(found)))
    if not given.names:
        print(experiment.states())
    elif not given.cases and options == Options(files=options.files):
        for page, text in experiment.shown().items():
            with atomic_write(page) as temporary:
                temporary.write_text(text)


if __name__ == "__main__":
    main()
