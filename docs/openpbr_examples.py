"""Writes the table of OpenPBR's example materials in docs/materialx.md.

usage: python docs/openpbr_examples.py FOLDER

FOLDER is `examples` of the repository AcademySoftwareFoundation/OpenPBR. The table says what parts
of OpenPBR each material asks for, and whether the plugin `openpbr` renders it; `table` makes it,
for the test as well.
"""

import re
import sys
import warnings
from pathlib import Path

import mitsuba as mi

import urushi
from urushi.errors import UrushiError, UrushiWarning

PAGE = Path(__file__).with_name("materialx.md")
BEGIN = "<!-- table of the examples: begin -->\n"
END = "<!-- table of the examples: end -->\n"

#: The weight of each part, and its name.
PARTS = {
    "coat_weight": "coat",
    "fuzz_weight": "fuzz",
    "thin_film_weight": "thin film",
    "emission_luminance": "emission",
    "transmission_weight": "transmission",
    "subsurface_weight": "subsurface",
    "geometry_thin_walled": "thin-walled",
}


def parts(path: Path) -> tuple[str, str]:
    """What a material asks for besides its opaque base, and what the plugin does with it."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UrushiWarning)  # colours outside of sRGB
            description = urushi.load_materialx(path)
    except UrushiError as error:
        return "", f"not read: {error}"
    found = [name for weight, name in PARTS.items() if description.get(weight)]
    if description.get("base_metalness"):
        found.insert(0, "metal")
    return ", ".join(found), outcome(description)


def outcome(description: dict) -> str:
    """What the plugin does with a description: it renders it, or says what it does not have."""
    try:
        mi.load_dict(urushi.openpbr(**description).on({"type": "sphere"}))
    except RuntimeError as error:  # Mitsuba's, around the plugin's own sentence
        sentence = str(error).strip().splitlines()[-1]
        asked = re.search(r"(\w+) needs ([\w -]+), which", sentence)
        return f"refused: {asked[2]} (`{asked[1]}`)" if asked else f"refused: {sentence}"
    return "rendered"


def table(folder: Path) -> str:
    """The table in Markdown: materials by what they ask for."""
    groups: dict[tuple[str, str], list[str]] = {}
    for path in sorted(folder.glob("*.mtlx")):
        name = path.stem.removeprefix("open_pbr_").replace("_", " ")
        groups.setdefault(parts(path), []).append(name)
    lines = ["| asks for | plugin `openpbr` | number | examples |", "|---|---|---|---|"]
    for (asked, result), names in sorted(groups.items()):
        label = asked or "only an opaque dielectric base"
        lines.append(f"| {label} | {result} | {len(names)} | {', '.join(names)} |")
    return "\n".join(lines) + "\n"


def main(folder: Path) -> None:
    mi.set_variant("llvm_ad_rgb")
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    PAGE.write_text(f"{before}{BEGIN}{table(folder)}{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
