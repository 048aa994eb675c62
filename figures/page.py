"""Writes the tables of all results into the docs: `python -m figures.page`.

Every plot.py has `tables`. A table of the page is found by its first line, and replaced. Sentences
beside it are not: read them again when numbers change.
"""

import importlib
import json
from collections.abc import Iterable, Sequence
from pathlib import Path

from urushi.files import atomic_write

FOLDER = Path(__file__).parent
DOCS = FOLDER.parent / "docs"
PAGE = DOCS / "figures.md"
#: Figures with a page of their own.
OTHERS = {name: DOCS / f"{name}.md" for name in ("simulator_biases", "slabs")}


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table."""
    first, *others = ["| " + " | ".join(cells) + " |" for cells in (head, *rows)]
    return "\n".join([first, "|---" * len(head) + "|", *others])


def names() -> list[str]:
    """The folders of all figures."""
    return sorted(path.parent.name for path in FOLDER.glob("*/plot.py"))


def tables(name: str) -> list[str]:
    """The tables of a figure's stored results."""
    found = json.loads((FOLDER / name / "results.json").read_text())
    return importlib.import_module(f"figures.{name}.plot").tables(found)


def replaced(text: str, new: str) -> str:
    """A page's text with the table whose first line is that of a new one replaced by it.

    Raises:
        ValueError: the page has no such table, or more than one.
    """
    head = new.partition("\n")[0]
    lines = text.split("\n")
    if lines.count(head) != 1:
        raise ValueError(f"the page has {lines.count(head)} tables with the first line '{head}'")
    start = end = lines.index(head)
    while end < len(lines) and lines[end].startswith("|"):
        end += 1
    return "\n".join([*lines[:start], *new.split("\n"), *lines[end:]])


def main() -> None:
    """Write all tables."""
    for name in names():
        page = OTHERS.get(name, PAGE)
        text = page.read_text()
        for new in tables(name):
            text = replaced(text, new)
        with atomic_write(page) as temporary:
            temporary.write_text(text)


if __name__ == "__main__":
    main()
