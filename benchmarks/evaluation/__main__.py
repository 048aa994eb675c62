"""Measure networks on layered materials that they were not trained on.

For every kind of stack, prints the errors E (energy-weighted, per stack) and P (relative, per pair
of directions) in per cent, with the reference's own error; then violations of physical laws, and
the sizes of the networks. docs/conventions.md defines E and P. Takes about a minute.

Example: python -m benchmarks.evaluation --weights weights.safetensors -o figures
"""

import argparse
from pathlib import Path

from benchmarks.evaluation import fan2022, report
from fan2022 import PaperNetworks

from urushi.errors import UrushiError


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--weights", help="weights file of the networks; default: the shipped ones")
    parser.add_argument("-o", "--output", type=Path, help="folder for the figures (figures.json)")
    parser.add_argument(
        "--fan2022",
        action="store_true",
        help="the weights are of the system of Fan et al. 2022, which are measured on the stacks "
        "whose indices are all above one; takes minutes to hours",
    )
    options = parser.parse_args()
    if options.fan2022 and not options.weights:
        parser.error("--fan2022 needs --weights, a file of its networks (docs/published.md)")
    try:
        if options.fan2022:
            print(fan2022.evaluate(PaperNetworks.read(options.weights)))
        else:
            print(report.report(options.weights, options.output))
    except UrushiError as error:
        parser.error(str(error))


if __name__ == "__main__":
    main()
