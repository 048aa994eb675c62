"""The demo: its shapes, its pattern, its scene, and what it writes."""

import json
import re
import shlex
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from urushi.app import cli
from urushi.app.commands import demo
from urushi.app.describe import describe
from urushi.errors import FileError
from urushi.eval import metrics
from urushi.scenes import caddy, caddy_pattern
from urushi.scenes.mesh import Mesh, lathe, write_ply
from urushi.scenes.options import Options


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return lathe(caddy.natsume(), 48, 96)


def _corners(mesh: Mesh) -> np.ndarray:
    """Faces by position: vertices that lie in one place (the seam, the poles) count as one."""
    _, same = np.unique(mesh.positions, axis=0, return_inverse=True)
    return same.reshape(-1)[mesh.faces]


def test_the_caddy_is_watertight_and_consistently_oriented(mesh):
    """Every directed edge occurs once, and its reverse once."""
    corners = _corners(mesh)
    edges = Counter(
        (int(a), int(b))
        for k in range(3)
        for a, b in zip(corners[:, k], corners[:, (k + 1) % 3], strict=True)
    )
    assert all(a != b for a, b in edges), "a triangle has no area"
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)
    vertices = len(np.unique(mesh.positions, axis=0))
    assert vertices - len(edges) // 2 + len(corners) == 2, "Euler's number of a sphere"


def test_the_caddy_is_oriented_outwards(mesh):
    """Its signed volume (divergence theorem) is positive and close to that of the profile."""
    a, b, c = (mesh.positions[mesh.faces[:, k]].astype(float) for k in range(3))
    volume = (np.cross(a, b) * c).sum() / 6
    points, _ = caddy.natsume()(np.linspace(0, 1, 4000))
    turned = np.pi * np.trapezoid(points[:, 0] ** 2, points[:, 1])
    # A 48-gon has (sin x) / x = 0.9971 of its circle's area, x = 2 pi / 48.
    assert volume == pytest.approx(turned * 0.9971, rel=2e-3)


def test_normals_are_unit_and_agree_with_the_triangles(mesh):
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-6)
    a, b, c = (mesh.positions[mesh.faces[:, k]].astype(float) for k in range(3))
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    cosines = [(flat * mesh.normals[mesh.faces[:, k]]).sum(1) for k in range(3)]
    assert np.min(cosines) > 0.5  # the groove of the lid turns within a few triangles
    assert np.median(cosines) > 0.995


def test_texture_coordinates_cover_the_unit_square(mesh):
    assert mesh.uv.min() == 0 and mesh.uv.max() == 1
    spread = np.ptp(mesh.uv[mesh.faces][..., 0], axis=1)
    assert spread.max() < 1.01 / 48, "no triangle crosses the seam"


def test_the_profile_is_parametrised_by_its_length():
    points, tangents = caddy.natsume()(np.linspace(0, 1, 4001))
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert np.ptp(steps) < 0.05 * steps.mean()
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1, atol=1e-12)
    assert points[0, 0] == points[-1, 0] == 0


def test_ply_holds_the_mesh(mesh, tmp_path):
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    write_ply(mesh, tmp_path / "caddy.ply")
    loaded = mi.load_dict({"type": "ply", "filename": str(tmp_path / "caddy.ply")})
    parameters = mi.traverse(loaded)
    for name, ours in (
        ("vertex_positions", mesh.positions),
        ("vertex_normals", mesh.normals),
        ("vertex_texcoords", mesh.uv),
        ("faces", mesh.faces),
    ):
        stored = np.array(parameters[name]).reshape(ours.shape)
        np.testing.assert_allclose(stored, ours, atol=2e-7)  # Mitsuba normalises normals again


def test_the_pattern_is_deterministic_and_in_range():
    first = caddy_pattern.gold(caddy.natsume(), 64)
    assert first.shape == (64, 128) and first.dtype == np.float32
    assert first.min() == 0 and 0.7 < first.max() <= 1
    np.testing.assert_array_equal(first, caddy_pattern.gold(caddy.natsume(), 64))
    assert (first != caddy_pattern.gold(caddy.natsume(), 64, seed=9)).any()


def test_the_pattern_closes_around_the_caddy():
    """Columns on both sides of the seam differ no more than other neighbours do."""
    image = caddy_pattern.gold(caddy.natsume(), 128)
    steps = np.abs(np.diff(image, axis=1)).mean(axis=0)
    assert np.abs(image[:, 0] - image[:, -1]).mean() <= steps.max()


def test_the_lacquer_is_a_valid_coat():
    depth, albedo = caddy.lacquer(96)
    assert depth.shape == albedo.shape == (96, 192, 3)
    assert depth.min() > 0 and depth.max() <= 8, "within what the networks are trained on"
    assert albedo.min() >= 0 and albedo.max() <= 1


def test_tone_curve_is_monotone_and_within_the_display_range():
    ramp = demo.tonemap(np.linspace(0, 50, 1000))
    assert ramp[0] == 0 and ramp[-1] == pytest.approx(1)
    assert (np.diff(ramp) >= 0).all()


def test_difference_shows_sign_and_size():
    grey = np.full((1, 3, 3), 0.45)
    shown = demo.difference_picture(grey * [[[1.0], [2.0], [0.5]]], grey)
    np.testing.assert_array_equal(shown[0, 0], 0)
    assert shown[0, 1, 0] > shown[0, 1, 2] and shown[0, 2, 2] > shown[0, 2, 0]


def test_figures_of_equal_images_are_their_noise():
    """Both renders have the halves 0.9 and 1.1: no difference, variance 0.01 each."""
    same = demo.Render(np.stack([np.full((4, 4, 3), 0.9), np.full((4, 4, 3), 1.1)]), 1.0, 2.0)
    figures = demo.compare(same, same)
    noise = 0.01 / (1 + 0.01)
    assert figures["layered_noise"] == figures["neural_layered_noise"] == pytest.approx(noise)
    assert figures["relative_mse"] == pytest.approx(-noise)
    assert figures["relative_mse_noise_free"] == pytest.approx(-2 * noise)


def test_a_small_demo_writes_every_file_and_its_pictures_agree(tmp_path, monkeypatch, capsys):
    """The relative mean squared error is below 0.01 once the walk's noise is subtracted."""
    monkeypatch.setattr(caddy, "TEXTURE_HEIGHT", 96)
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


def test_the_demo_says_what_a_picture_of_equal_noise_costs(tmp_path):
    figures = {
        f"{name}_{key}": value
        for name, values in (("neural_layered", (1.0, 3.0, 1e-3)), ("layered", (1.0, 4.0, 2e-3)))
        for key, value in zip(("start_seconds", "seconds", "noise"), values, strict=True)
    }
    text = " ".join(demo.describe({"relative_mse": 1.0} | figures, tmp_path).split())
    assert "takes 75% of the walk's time and has 50% of its noise" in text
    assert "the networks take 38% of the walk's time" in text  # three quarters of a half


@pytest.mark.parametrize("command", [command for command, _ in demo.NEXT_COMMANDS])
def test_the_suggested_commands_can_be_parsed(command):
    program, *arguments = shlex.split(command)
    assert program == "urushi"
    parsed = cli.parse(arguments)
    if hasattr(parsed, "description"):
        describe(parsed.description)


def test_renders_of_other_seeds_are_independent(variant, tmp_path, monkeypatch):
    """The squared difference of two renders is, on average, the sum of their variances.

    Half a dozen pairs of renders at 96 * 96 pixels lay within 6 % of that, relative to brightness;
    a seed that both renders share would leave nothing, and halves that share one would double it.
    """
    import mitsuba as mi

    mi.set_variant(variant)
    monkeypatch.setattr(caddy, "coat", lambda *_: {"type": "diffuse"})
    options = Options("layered", width=64, height=64, spp=32)
    first, second = (demo.render(tmp_path, options, seed) for seed in (0, 1))
    noise = metrics.relative_mse(first.image, second.image)
    both = first.variance + second.variance
    rest = metrics.relative_mse(first.image, second.image, variance=both)
    assert abs(rest) < 0.25 * noise


def test_unwritable_output_is_one_sentence(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert cli.main(["demo", "-o", str(tmp_path / "file" / "demo")]) == 2
    error = capsys.readouterr().err
    assert re.fullmatch(
        r"urushi: cannot create the folder .*; choose one that is writable\n", error
    )
    with pytest.raises(FileError, match=r"^cannot write .*; choose a folder that exists"):
        write_ply(lathe(caddy.natsume(), 4, 8), Path("/proc/caddy.ply"))


MULTIPLE = "it must be at least 16 and at most 65536 samples, a multiple of 16"


@pytest.mark.parametrize(
    ("option", "value", "sentence"),
    [
        ("--width", 0, "--width is 0; it must be at least 1 and at most 32768 pixels"),
        ("--spp", 0, f"--spp is 0; {MULTIPLE}"),
        ("--spp", 12, f"--spp is 12; {MULTIPLE}"),
        ("--spp", -16, f"--spp is -16; {MULTIPLE}"),
    ],
)
def test_bad_sizes_are_refused(option, value, sentence, tmp_path, capsys):
    assert cli.main(["demo", "-o", str(tmp_path / "demo"), option, str(value)]) == 2
    assert capsys.readouterr().err == f"urushi: {sentence}\n"
    assert not list(tmp_path.iterdir())
