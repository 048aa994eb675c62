"""Measures experiments, stores and draws their results, and writes their tables into the docs.

Without names, lists all experiments and says whose stored results are stale. `all` runs every one
of them, which takes a night, and `stale` those that have no results of the shipped weights. `pages`
writes the tables of stored results only. A run that is stopped continues with finished cases, which
are kept in out/figures.
"""

import importlib
from typing import Annotated

import mitsuba as mi
import tyro
from benchmarks import experiment
from benchmarks.experiment import Options

from urushi.files import atomic_write


def main(
    names: tyro.conf.Positional[tuple[str, ...]] = (),
    *,
    options: Annotated[Options, tyro.conf.OmitArgPrefixes] = Options(),  # noqa: B008
    cases: tuple[str, ...] = (),
    fresh: bool = False,
) -> None:
    """Run experiments.

    Args:
        names: of experiments, all, stale, or pages.
        options: of the run.
        cases: only these; nothing is stored.
        fresh: measure finished cases again.
    """
    known = experiment.names()
    for name in names:
        if name not in (*known, "all", "stale", "pages"):
            raise SystemExit(f"there is no experiment '{name}'; choose from {', '.join(known)}")
    mi.set_variant("llvm_ad_rgb")
    for name in known:
        if not {name, "all"} & {*names} and not ("stale" in names and experiment.state(name)):
            continue
        if found := experiment.run(name, options, cases, fresh):  # else it said why
            module = importlib.import_module(f"benchmarks.experiments.{name}")
            print(f"\n{name}: {(module.__doc__ or '').splitlines()[0]}\n")
            print("\n\n".join(experiment.load(name).tables(found)))
    if not names:
        print(experiment.states())
    elif not cases and options == Options(files=options.files):
        for page, text in experiment.shown().items():
            with atomic_write(page) as temporary:
                temporary.write_text(text)


if __name__ == "__main__":
    tyro.cli(main, prog="python -m benchmarks", description=__doc__)
