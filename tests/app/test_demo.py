"""The demo: its pictures, their comparison, and what it writes."""

import json
import re
import shlex

import numpy as np
import pytest
from gallery import caddy, export
from gallery.options import Options

from urushi.app import cli, demo, render
from urushi.app.describe import describe
from urushi.core import error_metrics as metrics


def test_tone_curve_is_monotone_and_the_difference_shows_sign_and_size():
    ramp = demo.tonemap(np.linspace(0, 50, 1000))
    assert ramp[0] == 0 and ramp[-1] == pytest.approx(1)
    assert (np.diff(ramp) >= 0).all()
    grey = np.full((1, 3, 3), 0.45)
    shown = demo.difference_picture(grey * [[[1.0], [2.0], [0.5]]], grey)
    np.testing.assert_array_equal(shown[0, 0], 0)
    assert shown[0, 1, 0] > shown[0, 1, 2] and shown[0, 2, 2] > shown[0, 2, 0]


def test_figures_of_equal_images_are_their_noise():
    """Both renders have a variance of 0.01, as of the halves 0.9 and 1.1."""
    same = demo.Render(np.ones((4, 4, 3)), np.full((4, 4, 3), 0.01), 1.0, 2.0)
    figures = demo.compare(same, same)
    noise = 0.01 / (1 + 0.01)
    assert figures["layered_noise"] == figures["neural_layered_noise"] == pytest.approx(noise)
    assert figures["relative_mse"] == pytest.approx(-noise)
    assert figures["relative_mse_noise_free"] == pytest.approx(-2 * noise)


def test_a_small_demo_writes_every_file_and_its_pictures_agree(tmp_path, monkeypatch, capsys):
    """The relative mean squared error is below 0.01 once the walk's noise is subtracted."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    small = export.export(caddy.caddy, tmp_path / "small", Options(detail=0.25))
    monkeypatch.setattr(render, "DEMO_SCENE", small)
    out = tmp_path / "new" / "demo"
    size = ["--width", "80", "--height", "72", "--spp", "128"]
    assert cli.main(["demo", "-o", str(out), *size]) == 0
    names = {"scene", "report.json", "comparison.png", "layered.exr", "neural_layered.exr"}
    assert {path.name for path in out.iterdir()} == names
    figures = json.loads((out / "report.json").read_text())
    assert figures["relative_mse"] < 0.01
    text = capsys.readouterr().out
    assert f"{figures['relative_mse']:.4f}" in text
    assert str(out / "comparison.png") in text


def test_the_demo_says_what_a_picture_of_equal_noise_costs_and_what_to_try(tmp_path):
    figures = {
        f"{name}_{key}": value
        for name, values in (("neural_layered", (1.0, 3.0, 1e-3)), ("layered", (1.0, 4.0, 2e-3)))
        for key, value in zip(("start_seconds", "seconds", "noise"), values, strict=True)
    }
    text = " ".join(demo.describe({"relative_mse": 1.0} | figures, tmp_path).split())
    assert "takes 75% of the walk's time and has 50% of its noise" in text
    assert "codes take 38% of the walk's time" in text  # three quarters of a half
    for command, _ in demo.NEXT_COMMANDS:
        program, *arguments = shlex.split(command)
        assert program == "urushi" and command in text
        parsed = cli.parse(arguments)
        if hasattr(parsed, "description"):
            describe(parsed.description)


def test_renders_of_other_seeds_are_independent(variant, tmp_path):
    """The squared difference of two renders is, on average, the sum of their variances.

    Half a dozen pairs of renders at 96 * 96 pixels lay within 6 % of that, relative to brightness;
    a seed that both renders share would leave nothing, and halves that share one would double it.
    """
    scene = export.export(caddy.caddy, tmp_path, Options(detail=0.05))
    first, second = (demo.render(scene, "layered", (64, 64), 32, seed) for seed in (0, 1))
    noise = metrics.relative_mse(first.image, second.image)
    both = first.variance + second.variance
    rest = metrics.relative_mse(first.image, second.image, variance=both)
    assert abs(rest) < 0.25 * noise


def test_unwritable_output_is_one_sentence(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert cli.main(["demo", "-o", str(tmp_path / "file" / "demo")]) == 2
    sentence = r"urushi: cannot create the folder .*; choose one that is writable\n"
    assert re.fullmatch(sentence, capsys.readouterr().err)
