import pytest

HEAD = '<?xml version="1.0"?>\n<materialx version="1.39" colorspace="{space}">{body}</materialx>'


@pytest.fixture(autouse=True)
def package():
    """MaterialX; tests are skipped where it is not installed."""
    return pytest.importorskip("MaterialX")


@pytest.fixture
def document(tmp_path):
    """A function that writes a document of some elements."""

    def write(body, space="lin_rec709", name="material.mtlx"):
        path = tmp_path / name
        path.write_text(HEAD.format(space=space, body=body))
        return path

    return write
