"""Pictures of materials in notebooks: PNG files whose pixels are those of lit spheres."""

import io

import numpy as np
import pytest

import urushi
from urushi.app import notebook
from urushi.material import Material

pytestmark = pytest.mark.usefixtures("rgb")


@pytest.fixture(autouse=True, scope="module")
def small():
    """Pictures of 24 x 24 pixels."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(notebook, "SIZE", 24)
        notebook.png.cache_clear()
        yield
    notebook.png.cache_clear()


def pixels(material: Material) -> np.ndarray:
    """The picture (H, W, 4), from 0 to 255."""
    image = pytest.importorskip("PIL.Image")
    file = material._repr_png_()
    assert file is not None and file.startswith(b"\x89PNG")
    return np.asarray(image.open(io.BytesIO(file))).astype(int)


def test_colours_are_those_of_the_surface():
    red = (0.8, 0.05, 0.05)
    dark, bright, red = (pixels(urushi.encode(urushi.diffuse(r))) for r in (0.1, 0.8, red))
    assert dark.shape == bright.shape == (24, 24, 4)
    inside = dark[..., 3] == 255
    assert inside[12, 12] and not inside[0, 0]
    assert (bright[inside][:, :3] > dark[inside][:, :3]).all()
    assert red[12, 12, 0] > 2 * red[12, 12, 1]


def test_anisotropy_shows():
    """Tangents are horizontal, so that exchanged widths are another picture."""
    one, other = (
        pixels(urushi.encode(urushi.conductor(alpha_u=u, alpha_v=v, r0=0.9)))
        for u, v in ((0.05, 0.5), (0.5, 0.05))
    )
    assert np.abs(one - other).max() > 50


def test_materials_of_other_numbers_of_channels_have_no_picture():
    grey = urushi.encode(urushi.diffuse(0.5))
    assert Material(grey.latents[:2], grey.model)._repr_png_() is None
    assert pixels(Material(grey.latents[:1], grey.model)).shape == (24, 24, 4)
