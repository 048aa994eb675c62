"""Materials in notebooks: `urushi.show`, the page with a material, and pictures of spheres."""

import functools
import html
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from urushi.app.page_files import page_document, page_files
from urushi.core import error_metrics as metrics
from urushi.errors import ParameterError
from urushi.material import Material
from urushi.nets import weights
from urushi.nets.weights import anisotropic_model, find

#: Height of the page in a notebook [pixels].
HEIGHT = 720

#: Size of a picture [pixels] and its samples per pixel.
SIZE, SAMPLES = 128, 64

#: Number of pictures that are remembered: a notebook shows the same material several times.
REMEMBERED = 32


@dataclass(frozen=True, eq=False)
class Page:
    """A page that IPython and Jupyter show."""

    document: str  # the page, a single HTML document that needs no server
    height: int  # in a notebook [pixels]

    def __repr__(self) -> str:
        return f"Page({len(self.document)} characters)"

    def _repr_html_(self) -> str:
        return (
            f'<iframe title="Urushi" width="100%" height="{self.height}" style="border: 0" '
            f'srcdoc="{html.escape(self.document)}"></iframe>'
        )


def show(material: Any, *, height: int = HEIGHT) -> Page:
    """Return the page of `urushi view` with a material, for display in a notebook.

    The notebook contains the whole page, about 2 MB, which computes in the browser. It needs
    neither the kernel nor a server, and works in a saved notebook too.

    Args:
        material: a `Material`, what `urushi.encode` takes, or an argument of `urushi view`, such
            as the path of a file.
        height: of the page [pixels].

    Raises:
        UrushiError: the page cannot show the material, see `urushi view`.
    """
    from urushi.app.view import first_material

    model = find(None)  # of isotropic materials
    if isinstance(material, Material):
        own = material.model
        if own.widths == 1:
            model = own
        elif own.fingerprint != anisotropic_model().fingerprint:
            raise ParameterError(
                f"the weights {own.fingerprint} are for anisotropic materials, for which the page "
                "supports only the shipped weights; encode the material with these"
            )
        if material.channels not in (1, 3):
            raise ParameterError(
                f"the material has {material.channels} channels; the page shows one or three"
            )
    return Page(page_document(page_files(model, first_material(material, None))), height)


@functools.lru_cache(REMEMBERED)
def png(material: Material) -> bytes:
    """A sphere under softboxes as a PNG file, transparent around it.

    Mitsuba renders it in the current variant, in llvm_ad_rgb if none is set.

    material: of one or three channels. The tangents of an anisotropic one are horizontal.
    """
    import mitsuba as mi  # lazily: a notebook may never show a material

    if mi.variant() is None:
        mi.set_variant("llvm_ad_rgb")
    with TemporaryDirectory() as temporary:
        file, networks = (Path(temporary, name) for name in ("material", "weights"))
        material.save(file)
        weights.save(networks, material.model.arch, material.model.params, {})
        options = {"material": str(file), "weights": str(networks), "size": str(SIZE)}
        scene = mi.load_file(str(Path(__file__).parent / "sphere" / "scene.xml"), **options)
    picture = np.array(mi.render(scene, spp=SAMPLES))
    pixels = np.concatenate([metrics.shown(picture[..., :3]), picture[..., 3:].clip(0, 1)], axis=-1)
    stream = mi.MemoryStream()
    bitmap = mi.Bitmap((255 * pixels + 0.5).astype(np.uint8), mi.Bitmap.PixelFormat.RGBA)
    bitmap.write(stream, mi.Bitmap.FileFormat.PNG)
    return bytes(stream.raw_buffer())
