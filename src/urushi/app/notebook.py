"""`urushi.show`: the page with a material in a notebook."""

import html
from typing import Any

from urushi.app.page_files import First, cards_of, codes_of, page_document, page_files
from urushi.errors import ParameterError
from urushi.material import Material
from urushi.nets.weights import Model, anisotropic_model, find

#: Height of the page in a notebook [pixels].
HEIGHT = 720


class Page:
    """A page that IPython and Jupyter show.

    Attributes:
        document: the page, a single HTML document that needs no server.
        height: in a notebook [pixels].
    """

    def __init__(self, document: str, height: int):
        self.document, self.height = document, height

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
        material: a `Material`, a description (a `Stack` or a surface), or an argument of `urushi
            view`, such as the path of a file.
        height: of the page [pixels].

    Raises:
        UrushiError: the page cannot show the material, see `urushi view`.
    """
    from urushi.app.commands.view import first_material

    model = find(None)
    if isinstance(material, str):
        first = first_material(material, None)
    elif isinstance(material, Material):
        model = _page_model(material.model)
        if material.channels not in (1, 3):
            raise ParameterError(
                f"the material has {material.channels} channels; the page shows one or three"
            )
        first = First(codes_of(material, "Material"))
    else:
        cards = cards_of(material)
        if cards is None:
            raise ParameterError(
                "the page has no cards for this description; pass urushi.encode(description)"
            )
        first = First(cards)
    return Page(page_document(page_files(model, first)), height)


def _page_model(model: Model) -> Model:
    """The networks of isotropic materials beside which the page has a material's own."""
    if model.widths == 1:
        return model
    if model.fingerprint != anisotropic_model().fingerprint:
        raise ParameterError(
            f"the weights {model.fingerprint} are for anisotropic materials, for which the page "
            "supports only the shipped weights; encode the material with these"
        )
    return find(None)
