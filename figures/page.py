"""Writes the tables of all results into the docs: `python -m figures.page`.

Every plot.py has `tables`. A table is found by its first line, and replaced on each page of its
figure that has one. So is the sentence that begins with "Source:" and names the figure's command.
Other sentences are not: read them again when numbers change.
"""

import importlib
import json
import re
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path

from urushi.files import atomic_write

FOLDER = Path(__file__).parent
DOCS = FOLDER.parent / "docs"
MODEL_CARD = FOLDER.parent / "src" / "urushi" / "nets" / "weights" / "README.md"
#: Pages of figures that have pages of their own; others are on the last one.
PAGES = {name: (DOCS / f"{name}.md",) for name in ("simulator_biases", "slabs")}
PAGES["evaluation"] = FOLDER.parent / "README.md", DOCS / "results.md", MODEL_CARD
PAGE = DOCS / "figures.md"


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


def pages(name: str) -> tuple[Path, ...]:
    """The pages of a figure."""
    return PAGES.get(name, (PAGE,))


def source(name: str) -> str:
    """The sentence that states how a figure's stored results were made."""
    found = json.loads((FOLDER / name / "results.json").read_text())
    parts = [f"Source: `python -m figures.{name}.compute`", found["date"], found["processor"]]
    parts += [f"{key} {found[key]}" for key in found if key.endswith("weights")]
    return textwrap.fill("; ".join(parts) + ".", 100, break_on_hyphens=False)


def shown(name: str) -> dict[Path, str]:
    """The texts of a figure's pages with the tables and the source of its stored results.

    Raises:
        ValueError: a table is on none of the pages, or twice on one.
    """
    texts = {page: page.read_text() for page in pages(name)}
    for new in tables(name):
        head = new.partition("\n")[0]
        chosen = [page for page in texts if head in texts[page].split("\n")]
        if not chosen:
            raise ValueError(f"no page of {name} has a table with the first line '{head}'")
        for page in chosen:
            texts[page] = replaced(texts[page], new)
    sentence = rf"Source: `python -m figures\.{name}\.compute`;.*?\.(?=\n\n|\n?\Z)"
    begin = re.compile(sentence, re.DOTALL)
    return {page: begin.sub(lambda _: source(name), text) for page, text in texts.items()}


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
        for page, text in shown(name).items():
            with atomic_write(page) as temporary:
                temporary.write_text(text)


if __name__ == "__main__":
    main()
