"""Names in the documentation exist: modules, functions, files, benchmarks and make targets."""

import re
from functools import cache
from importlib import import_module
from pathlib import Path

import mitsuba as mi
import pytest

import urushi

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src"
PAGES = sorted(page for kind in ("md", "rst") for page in ROOT.glob(f"docs/**/*.{kind}"))
PAGES += sorted([*ROOT.glob("*.md"), *SOURCE.glob("**/*.md")])
FLOORS = sorted(path.parent.name for path in SOURCE.glob("urushi/*/__init__.py"))


@cache
def exists(dotted: str) -> bool:
    """Whether a dotted name is a module of the package, or begins with one and a name in it."""
    mi.set_variant("llvm_ad_rgb")  # modules of plugins need one
    module, parts = urushi, dotted.split(".")[1:]
    for part in parts:
        try:
            module = import_module(f"{module.__name__}.{part}")
        except ModuleNotFoundError:
            return hasattr(module, part)
    return True


def in_code(page: Path) -> list[str]:
    """The text between single backticks of a page, and its code blocks."""
    return re.findall(r"```.*?```|`[^`\n]+`", page.read_text(), re.DOTALL)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_names_of_the_package_exist(page):
    text = "\n".join(in_code(page))
    dotted = set(re.findall(r"(?<![\w./-])urushi(?:\.[A-Za-z_]\w*)+(?!\w|\.html)", text))
    assert [name for name in sorted(dotted) if not exists(name)] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_files_benchmarks_and_targets_exist(page):
    text = "\n".join(in_code(page))
    files = set(re.findall(r"(?<![\w./-])((?:[\w-]+/)*[\w-]+\.py)\b", text))
    places = [ROOT, SOURCE, SOURCE / "urushi", page.parent, ROOT / "docs"]
    folders = [p.parent for place in places[:3] for p in place.glob("**/*.py")] if files else []
    missing = [
        name
        for name in sorted(files)
        if not any((place / name).is_file() for place in [*places, *folders])
    ]
    assert missing == []
    modules = set(re.findall(r"python -m (benchmarks(?:\.\w+)+)", text))
    paths = {m: ROOT / m.replace(".", "/") for m in modules}
    files = {m: (p.with_suffix(".py"), p / "__main__.py") for m, p in paths.items()}
    assert [m for m, places in files.items() if not any(map(Path.is_file, places))] == []
    makefile = (ROOT / "Makefile").read_text()
    targets = set(re.findall(r"\bmake ([a-z][\w-]+)", text))
    assert [t for t in targets if not re.search(rf"^{re.escape(t)}:", makefile, re.MULTILINE)] == []


@pytest.mark.parametrize("floor", FLOORS)
def test_docstrings_and_comments_name_what_exists(floor):
    """References such as `material.fit` or `urushi.nets.weights.read` in the source itself."""
    wrong = []
    for path in sorted(SOURCE.glob(f"urushi/{floor}/**/*.py")):
        quoted = re.findall(r"(?<!`)`([A-Za-z_][\w.]*)`", path.read_text())
        for name in sorted(set(quoted)):
            first, *rest = name.removeprefix("urushi.").split(".")
            if first in FLOORS and rest and not exists(f"urushi.{first}.{'.'.join(rest)}"):
                wrong.append(f"{path.relative_to(SOURCE)}: {name}")
    assert wrong == []


def test_tables_of_parameters_fit_their_page():
    """A column is at least as wide as its longest word, and 2 characters of margin. The text is as
    wide as 92 characters of code, on the widest screen too."""
    page = (ROOT / "docs" / "reference" / "parameters.md").read_text()
    tables = re.findall(r"(?:^\|.*\n)+", page, re.MULTILINE)
    assert len(tables) == 4
    for table in tables:
        rows = [line.strip()[1:-1].split("|") for line in table.splitlines()]
        words = [[max(map(len, cell.split()), default=0) + 2 for cell in row] for row in rows]
        widths = [max(column) for column in zip(*words, strict=True)]
        assert sum(widths) <= 92, rows[0]
