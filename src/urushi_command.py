"""The console script `urushi`: an interrupt is one sentence, also while Python still imports.

It is no part of the package, because importing any part of that imports Mitsuba first.
"""

import sys


def main() -> int:
    """`urushi.app.cli.main`, with its exit code for an interrupt."""
    try:
        from urushi.app import cli

        return cli.main()
    except KeyboardInterrupt:
        print("urushi: interrupted; nothing half-written was left behind", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
