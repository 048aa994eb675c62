"""Every numeric option of every command refuses values out of its range, in one sentence."""

import math
from typing import Any, get_args, get_type_hints

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


def is_number(hint: Any) -> bool:
    """Whether a value of the type may be a number."""
    return hint in (int, float) or any(map(is_number, get_args(hint)))


def options() -> list[tuple[str, str, Range | None]]:
    """Command, field and range of every option that is a number."""
    return [
        (name, field, ranges.range_of(hint))
        for name, (command, _) in cli.COMMANDS.items()
        for field, hint in get_type_hints(command, include_extras=True).items()
        if is_number(hint) and field not in OF_COATS
    ]


def bad_values(bounds: Range, whole: bool) -> list[str]:
    """Values just outside, far outside, and no numbers at all."""
    step = 1 if whole else 1e-3
    values = [bounds.least if bounds.above else bounds.least - step, -(10**12)]
    values += [bounds.least + 1] * (bounds.step > 1)
    if bounds.most < math.inf:
        values += [bounds.most if bounds.below else bounds.most + step, 10**12]
    return [f"{x:.0f}" if whole else repr(float(x)) for x in values] + ([] if whole else ["nan"])


@pytest.mark.parametrize(("name", "field", "bounds"), options())
def test_bad_values_are_refused_before_any_work(name, field, bounds, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    option = "--" + field.replace("_", "-")
    for value in bad_values(bounds, field not in ("detail", "incidence", "azimuth")):
        assert cli.main([name, *NEEDED.get(name, []), option, value]) == cli.FAILURE
        error = capsys.readouterr().err
        assert error.startswith(f"urushi: {option} is ") and error.count("\n") == 1
        assert f"it must be {bounds}" in error
    assert not bounds.step or f"a multiple of {bounds.step}" in error
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("option", ["--seed", "--sensor"])
def test_whole_numbers_that_no_float_can_hold(option, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.xml").write_text('<scene version="3.0.0"><sensor type="perspective"/></scene>')
    assert cli.main(["render", "a.xml", option, "9" * 400]) == cli.FAILURE
    assert capsys.readouterr().err.startswith(f"urushi: {option} is 999")


@pytest.mark.parametrize("text", ["abc", "", "1e5x"])
def test_what_is_no_number_is_a_usage_error(text, capsys):
    with pytest.raises(SystemExit) as caught:
        cli.main(["render", "caddy", "--spp", text])
    assert caught.value.code == cli.FAILURE
    assert "--spp" in "".join(capsys.readouterr())
