"""The `urushi` command: parses the arguments, runs one subcommand, reports its failure."""

import functools
import operator
import os
import sys
import warnings
from collections.abc import Mapping, Sequence
from typing import Annotated, Any

import tyro
from tqdm import tqdm

import urushi
from urushi import ranges
from urushi.app.demo import Demo
from urushi.app.describe import Materials
from urushi.app.doctor import Doctor
from urushi.app.encode import Encode, Layer
from urushi.app.export import Convert, Export
from urushi.app.recipe import Recipe
from urushi.app.render import Render, Scene, raise_interrupt
from urushi.app.simulate import Simulate
from urushi.app.train import Data, Train
from urushi.app.view import View
from urushi.errors import UrushiError, UrushiWarning

FAILURE = 2
INTERRUPTED = 130  # 128 + SIGINT, as shells report it
OUTPUT_CLOSED = 141  # 128 + SIGPIPE

DESCRIPTION = """Layered materials by light transport and latent codes, for Mitsuba 3.

Start with `urushi demo`. If something does not work, `urushi doctor` says why. Every command has
help with an example: `urushi render --help`.
"""


#: Subcommands by name, each with its line in the list of commands.
Commands = Mapping[str, tuple[type, str]]

COMMANDS: Commands = {
    "demo": (Demo, "Render a lacquered object by codes and by the reference, and compare."),
    "render": (Render, "Render a Mitsuba scene file or the demo's scene."),
    "scene": (Scene, "Write the demo's scene into a folder."),
    "simulate": (Simulate, "Simulate the BRDF of a layered material without bias."),
    "encode": (Encode, "Encode a BRDF into a material file."),
    "layer": (Layer, "Coat a material."),
    "materials": (Materials, "List the library of described materials."),
    "recipe": (Recipe, "Find measured paints that give a colour over a ground."),
    "export": (Export, "Write a material as code: GLSL, WGSL, HLSL, Slang, OSL, Python."),
    "convert": (Convert, "Write a material of a MaterialX document as a Mitsuba scene."),
    "view": (View, "Coat a material by hand, on a page in the browser."),
    "data": (Data, "Compute training data."),
    "train": (Train, "Make a basis and its layering network."),
    "doctor": (Doctor, "Check this machine and say what is missing."),
}


def parse(
    arguments: Sequence[str],
    commands: Commands = COMMANDS,
    prog: str = "urushi",
    description: str = DESCRIPTION,
) -> Any:
    """The command object of the arguments; exits the process if they cannot be parsed."""
    listing = list(arguments) in ([], ["-h"], ["--help"])  # with the one-line descriptions
    members = (
        Annotated[command, tyro.conf.subcommand(name, description=summary if listing else None)]
        for name, (command, summary) in commands.items()
    )
    union: Any = functools.reduce(operator.or_, members)
    return tyro.cli(
        union,
        prog=prog,
        description=description,
        args=arguments or ["--help"],
        config=(tyro.conf.OmitArgPrefixes, tyro.conf.FlagCreatePairsOff),
    )


def main(
    args: Sequence[str] | None = None,
    commands: Commands = COMMANDS,
    prog: str = "urushi",
    description: str = DESCRIPTION,
) -> int:
    """Run the command of `args` (default: the process's arguments); returns the exit code.

    0: success; 1: `doctor` found a problem that keeps Urushi from working; 2: a user's error,
    printed as one sentence to standard error, as warnings are; 130: interrupted; 141: the reader of
    standard output has closed it, as `head` does.
    """
    arguments = list(sys.argv[1:] if args is None else args)
    try:
        try:
            return _run(arguments, commands, prog, description)
        finally:  # also after the help, which exits
            print(end="", flush=True)  # to nowhere if there is no standard output
    except UrushiError as error:
        return _failed(str(error))
    except MemoryError:
        return _failed("this machine has too little memory; ask for fewer pixels, texels or walks")
    except KeyboardInterrupt:
        print("urushi: interrupted; nothing half-written was left behind", file=sys.stderr)
        return INTERRUPTED
    except OSError as error:
        if error.filename is not None:
            place = f"cannot use '{error.filename}': {error.strerror}"
            return _failed(f"{place}; check the path and its permissions")
        try:
            print(flush=True)  # is it standard output that fails?
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for the rest of it
            if isinstance(error, BrokenPipeError):
                return OUTPUT_CLOSED
            return _failed(
                f"cannot write to standard output: {error.strerror}; free some space or send it "
                "elsewhere"
            )
        raise


def _failed(sentence: str) -> int:
    """Print an error; returns its exit code."""
    print(f"urushi: {sentence}", file=sys.stderr)
    return FAILURE


def _run(arguments: Sequence[str], commands: Commands, prog: str, description: str) -> int:
    """Run the command of the arguments, and show its warnings; returns the exit code."""
    if list(arguments) == ["--version"]:
        print(urushi.__version__)
        return 0
    command = parse(arguments, commands, prog, description)
    ranges.check(command)
    as_python: Any = warnings.showwarning

    def show(message: Any, category: type, *place: Any, **names: Any) -> None:
        """Print a warning of Urushi as one sentence, above a progress bar; others as Python."""
        if issubclass(category, UrushiWarning):
            tqdm.write(f"urushi: {message}", file=sys.stderr)
        else:
            as_python(message, category, *place, **names)

    with warnings.catch_warnings():
        warnings.simplefilter("default", UrushiWarning)
        warnings.showwarning = show
        try:
            return command.run()
        except (RuntimeError, SystemError) as error:  # C++ wraps interrupts, also within imports
            raise_interrupt(error)
            raise


if __name__ == "__main__":
    sys.exit(main())
