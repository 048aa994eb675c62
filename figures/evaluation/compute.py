"""Computes the errors of the shipped networks and the laws of physics: see README.md.

python -m figures.evaluation.compute
"""

from dataclasses import asdict
from pathlib import Path

from benchmarks.evaluation import benchmark, report

from figures import results
from urushi.nets.weights import default_model

FOLDER = Path(__file__).parent


def main() -> None:
    """Compute all figures and write results.json."""
    found = report.measure(default_model(), benchmark.read())
    results.write(
        FOLDER / "results.json",
        {
            "weights": found.fingerprint,
            "rows": found.rows,
            "laws": [asdict(law) | {"kept": law.kept} for law in found.laws],
        },
    )


if __name__ == "__main__":
    main()
