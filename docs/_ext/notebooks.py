"""Sphinx parser of notebooks with their stored results: as MyST, with pictures inside the page."""

import html
import json
from typing import Any

from docutils import nodes
from myst_parser.parsers.sphinx_ import MystParser
from sphinx.application import Sphinx

PICTURES = ("image/jpeg", "image/png")


class NotebookParser(MystParser):
    """Markdown cells are read by MyST, code cells and results become blocks."""

    supported = ("ipynb",)

    def parse(self, inputstring: str, document: nodes.document) -> None:
        blocks: list[str] = []
        for cell in json.loads(inputstring)["cells"]:
            text = "".join(cell["source"])
            if cell["cell_type"] == "markdown":
                blocks.append(text)
            elif text:
                blocks.append(f"```python\n{text}\n```")
            blocks += [block for output in cell.get("outputs", ()) if (block := shown(output))]
        super().parse("\n\n".join(blocks), document)


def shown(output: dict[str, Any]) -> str:
    """A result of a cell; "" if it is none that a page shows."""
    data = output.get("data", {"text/plain": output.get("text", "")})
    for kind in PICTURES:
        if kind in data:
            content = "".join(data[kind].split())
            text = html.escape("".join(data.get("text/plain", "")))
            return f'<img alt="{text}" src="data:{kind};base64,{content}">'
    text = "".join(data.get("text/plain", ""))
    return f"```text\n{text.rstrip()}\n```" if text.strip() else ""


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_source_suffix(".ipynb", "ipynb")
    app.add_source_parser(NotebookParser)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
