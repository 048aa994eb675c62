"""The `urushi` command: reads the arguments into one command object, runs it, reports failure."""

import functools
import operator
import os
import sys
from collections.abc import Sequence
from typing import Annotated, Any

import tyro

from urushi import paper
from urushi.app.commands.data import Data
from urushi.app.commands.encode import Encode
from urushi.app.commands.layer import Layer
from urushi.app.commands.render import Render, Scenes
from urushi.app.commands.sheet import Sheet
from urushi.app.commands.simulate import Simulate
from urushi.app.commands.train import Evaluate, Train
from urushi.app.demo import Demo
from urushi.app.doctor import Doctor
from urushi.errors import UrushiError
from urushi.version import __version__

FAILURE = 2
INTERRUPTED = 130  # 128 + SIGINT, as shells report it
UNHEARD = 141  # 128 + SIGPIPE

DESCRIPTION = """Layered materials in a neural latent space, for Mitsuba 3.

Start with `urushi demo`; if something is amiss, `urushi doctor` says what. Every command
explains itself and gives an example: `urushi render --help`.
"""


#: Every subcommand, and its line in the list of all.
COMMANDS: dict[str, tuple[type, str]] = {
    "demo": (Demo, "Render a lacquered object and its reference."),
    "render": (Render, "Render a Mitsuba scene file or a shipped scene."),
    "scenes": (Scenes, "Write a shipped scene into a folder."),
    "simulate": (Simulate, "Simulate a layered material without bias."),
    "encode": (Encode, "Encode a BRDF into a material file."),
    "layer": (Layer, "Coat a material in the latent space."),
    "sheet": (Sheet, "Draw blends of materials under coats."),
    "data": (Data, "Generate training data, or look at them."),
    "train": (Train, "Train the networks."),
    "eval": (Evaluate, "Measure networks on held-out materials."),
    "doctor": (Doctor, "Say what this machine has, and what is wrong."),
}


def _union(listing: bool) -> Any:
    """The type that tyro reads; the list of all shows summaries, a command its own full text."""
    members = (
        Annotated[command, tyro.conf.subcommand(name, description=summary if listing else None)]
        for name, (command, summary) in COMMANDS.items()
    )
    return functools.reduce(operator.or_, members)


def parse(arguments: Sequence[str]) -> Any:
    """The command object that the arguments describe; exits where they describe none."""
    listing = list(arguments) in ([], ["-h"], ["--help"])
    return tyro.cli(
        _union(listing),
        prog="urushi",
        description=DESCRIPTION,
        args=arguments or ["--help"],
        config=(tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff),
    )


def main(args: Sequence[str] | None = None) -> int:
    """Run the command that `args` (default: the process's) name; returns the exit code.

    0: done; 1: `doctor` found something essential wrong; 2: a user's error, told in one sentence
    on standard error; 130: interrupted; 141: who read the output has gone, as `head` does.
    """
    arguments = list(sys.argv[1:] if args is None else args)
    if arguments == ["--version"]:
        print(__version__)
        return 0
    command = parse(arguments)
    try:
        paper.register()
        code = command.run()
        sys.stdout.flush()
        return code
    except UrushiError as error:
        print(f"urushi: {error}", file=sys.stderr)
        return FAILURE
    except KeyboardInterrupt:
        print("urushi: interrupted; nothing half-written was left behind", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        if not _unheard():
            raise
        return UNHEARD


def _unheard() -> bool:
    """Whether nobody reads standard output; if so, what is left of it goes nowhere."""
    try:
        print(flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return True
    return False


if __name__ == "__main__":
    sys.exit(main())
