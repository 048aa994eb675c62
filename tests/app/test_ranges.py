"""Every numeric option of every command refuses values out of its range, in one sentence."""

import dataclasses
import math
from collections.abc import Iterator
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import pytest

from urushi import ranges
from urushi.app import cli
from urushi.ranges import Range

#: Arguments that the commands need beside the option.
NEEDED = {
    "render": ["scene.xml"],
    "simulate": ["diffuse(0.5)"],
    "recipe": ["#7a2f1e"],
    "encode": ["diffuse(0.5)", "-o", "a.safetensors"],
    "layer": ["diffuse(0.5)", "-o", "a.safetensors"],
    "convert": ["a.mtlx", "-o", "folder"],
    "data": ["-o", "a"],
}
#: Parameters of coats, and colours: their ranges are those of `urushi.coat` and `urushi.diffuse`,
#: whose own tests check them.
OF_COATS = {"alpha", "alpha_u", "alpha_v", "ior", "eta", "albedo", "sigma_t", "g"}
OF_COATS |= {"color", "body", "body_color", "thickness", "ground"}


def commands() -> dict[str, type]:
    """The commands by their words, those inside others included."""
    found = {}
    for name, (command, _) in cli.COMMANDS.items():
        hints = get_type_hints(command, include_extras=True)
        inner = get_args(hints["command"]) if "command" in hints else ()
        if get_origin(hints.get("command")) is Annotated:
            inner = (hints["command"],)
        for member in inner:
            kind, *notes = get_args(member)
            (given,) = (note.name for note in notes if hasattr(note, "name"))
            found[f"{name} {given}"] = kind
        if not inner:
            found[name] = command
    return found


def is_number(hint: Any) -> bool:
    """Whether a value of the type may be a number."""
    if hint in (int, float):
        return True
    parts = get_args(hint)
    return any(map(is_number, parts[:1] if get_origin(hint) is Annotated else parts))


def fields(command: type) -> Iterator[tuple[str, Any]]:
    """Names and types of a command's options, those of nested dataclasses included."""
    for name, hint in get_type_hints(command, include_extras=True).items():
        inner = get_args(hint)[0] if get_origin(hint) is Annotated else hint
        if dataclasses.is_dataclass(inner):
            yield from fields(inner)
        elif name in command.__dataclass_fields__:
            yield name, hint


def options() -> list[tuple[str, str, list[Range]]]:
    """Command, field and ranges of every option that is a number."""
    return [
        (name, field, ranges.ranges_of(hint))
        for name, command in commands().items()
        for field, hint in fields(command)
        if is_number(hint) and field not in OF_COATS
    ]


def bad_values(bounds: Range, whole: bool) -> list[str]:
    """Values just outside, far outside, and no numbers at all."""
    step = 1 if whole else 1e-3
    values = [bounds.least if bounds.above else bounds.least - step, -(10**12)]
    if bounds.most < math.inf:
        values += [bounds.most if bounds.below else bounds.most + step, 10**12]
    return [f"{x:.0f}" if whole else repr(float(x)) for x in values] + ([] if whole else ["nan"])


@pytest.mark.parametrize(("name", "field", "found"), options())
def test_bad_values_are_refused_before_any_work(name, field, found, tmp_path, monkeypatch, capsys):
    (bounds,) = found  # every number has one range
    monkeypatch.chdir(tmp_path)
    option = "--" + field.replace("_", "-")
    for value in bad_values(bounds, field not in ("detail", "incidence", "azimuth")):
        assert cli.main([*name.split(), *NEEDED.get(name, []), option, value]) == cli.FAILURE
        error = capsys.readouterr().err
        assert error.startswith(f"urushi: {option} is ") and error.count("\n") == 1
        assert "it must be " in error
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("text", ["abc", "", "1e5x"])
def test_what_is_no_number_is_a_usage_error(text, capsys):
    with pytest.raises(SystemExit) as caught:
        cli.main(["render", "caddy", "--spp", text])
    assert caught.value.code == cli.FAILURE
    assert "--spp" in "".join(capsys.readouterr())


def test_all_commands_are_reached():
    assert {"data", "demo"} <= set(commands()) and len(options()) > 15
