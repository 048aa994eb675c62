"""Sphinx directive `.. plugin:: NAME`: the doc block of a Mitsuba plugin, from its source.

Plugins are classes, functions that make them, or classes inside functions called `define`, which
autodoc cannot see. Their docstrings are read from the syntax tree of every file below `src/urushi`
whose folder is called `plugins`: Mitsuba is not imported. The first sentence of a doc
block ends with the plugin's name in parentheses, such as (``layered``).

A doc block is written with the directives of Mitsuba's own documentation, `tabs` and `code-tab`;
they are shown by sphinx-design.
"""

import ast
import inspect
import re
from collections.abc import Iterator
from pathlib import Path

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.logging import getLogger

SOURCE = Path(__file__).parents[2] / "src" / "urushi"
NAME = re.compile(r"\(``(\w+)``\)\.?\s*$")

logger = getLogger(__name__)


def doc_blocks() -> dict[str, tuple[Path, str]]:
    """Name of every plugin -> its file and its doc block."""
    blocks = {}
    for path in sorted(SOURCE.rglob("plugins/*.py")):
        for doc in _docstrings(ast.parse(path.read_text(encoding="utf-8"))):
            found = NAME.search(doc.partition("\n")[0])
            if found:
                blocks[found[1]] = path, doc
    return blocks


def _docstrings(tree: ast.Module) -> Iterator[str]:
    """Docstrings of classes and functions, and of those inside functions called `define`."""
    for outer in tree.body:
        define = isinstance(outer, ast.FunctionDef) and outer.name == "define"
        for node in outer.body if define else [outer]:  # type: ignore[attr-defined]
            if isinstance(node, ast.ClassDef | ast.FunctionDef):
                yield inspect.cleandoc(ast.get_docstring(node) or "")


def with_tabs(doc: str) -> str:
    """A doc block with `tabs` and `code-tab` replaced by sphinx-design's directives."""
    doc = re.sub(r"^(\s*)\.\. tabs::", r"\1.. tab-set-code::", doc, flags=re.MULTILINE)
    return re.sub(r"^(\s*)\.\. code-tab:: (\w+)", r"\1.. code-block:: \2", doc, flags=re.MULTILINE)


class Plugin(SphinxDirective):
    """Insert the doc block of the plugin that the argument names."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        blocks = doc_blocks()
        name = self.arguments[0]
        if name not in blocks:
            raise self.error(f"no plugin '{name}' below {SOURCE}; there are {', '.join(blocks)}")
        path, doc = blocks[name]
        self.env.note_dependency(str(path))
        self.env.metadata[self.env.docname].setdefault("plugins", "")
        self.env.metadata[self.env.docname]["plugins"] += f"{name} "
        lines = StringList(with_tabs(doc).splitlines(), source=str(path))
        container = nodes.container(classes=["plugin"])
        self.state.nested_parse(lines, self.content_offset, container)
        return container.children


def check_all_shown(app: Sphinx, env) -> None:
    """Warn of plugins that no page shows."""
    shown = {name for data in env.metadata.values() for name in data.get("plugins", "").split()}
    for name, (path, _) in doc_blocks().items():
        if name not in shown:
            logger.warning("the plugin '%s' of %s is on no page", name, path)


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_directive("plugin", Plugin)
    app.connect("env-check-consistency", check_all_shown)
    return {"parallel_read_safe": True}
