import numpy as np
import pytest

HEAD = '<?xml version="1.0"?>\n<materialx version="1.39" colorspace="{space}">{body}</materialx>'


@pytest.fixture(autouse=True)
def package():
    """MaterialX; tests are skipped where it or OpenImageIO is not installed."""
    pytest.importorskip("OpenImageIO")
    return pytest.importorskip("MaterialX")


def element(tag, kind, name="n", **inputs):
    """The text of a node.

    inputs: numbers, truth values, colours as tuples, or pairs of a type and a text; a text that
    begins with @ names a node, of type float unless another is given; one with = is attributes.
    """
    inside = ""
    for key, x in inputs.items():
        if isinstance(x, tuple) and not isinstance(x[0], str):
            x = "color3", ", ".join(map(str, x))
        kinds = {bool: "boolean", int: "integer", float: "float", str: "float"}
        of, value = x if isinstance(x, tuple) else (kinds[type(x)], str(x).lower())
        link = "nodename" if value.startswith("@") else "value"
        link = value if "=" in value else f'{link}="{value.lstrip("@")}"'
        inside += f'<input name="{key.rstrip("_")}" type="{of}" {link}/>'
    return f'<{tag} name="{name}" type="{kind}">{inside}</{tag}>'


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
