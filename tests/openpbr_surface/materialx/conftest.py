import numpy as np
import pytest

HEAD = '<?xml version="1.0"?>\n<materialx version="1.39" colorspace="{space}">{body}</materialx>'


@pytest.fixture(autouse=True)
def package():
    """MaterialX; tests are skipped where it or OpenImageIO is not installed."""
    pytest.importorskip("OpenImageIO")
    return pytest.importorskip("MaterialX")


def write_image(path, pixels, kind="float"):
    """Write values (height, width, channels) as OpenEXR or TIFF, in single precision or a kind."""
    import OpenImageIO

    image = OpenImageIO.ImageBuf(np.ascontiguousarray(pixels, np.float32))
    assert image.write(str(path), kind)


@pytest.fixture
def document(tmp_path):
    """A function that writes a document of some elements."""

    def write(body, space="lin_rec709", name="material.mtlx"):
        path = tmp_path / name
        path.write_text(HEAD.format(space=space, body=body))
        return path

    return write
