"""Counts the materials of a collection of MaterialX documents that are read and rendered.

usage: python docs/materialx_collection.py FOLDER [--uv-plane]

Prints the number of materials in all documents below FOLDER, of those that `load_materialx` reads,
and of those that the plugin `openpbr` renders, then the reasons against. Patterns have 8^2 texels.
"""

import re
import sys
import warnings
from collections import Counter
from pathlib import Path

import mitsuba as mi

from urushi.errors import UrushiError, UrushiWarning
from urushi.openpbr_surface.materialx.document import materials, read_document
from urushi.openpbr_surface.materialx.surface import read_surface
from urushi.openpbr_surface.plugins.materialx import check_supported


def outcomes(path: Path, uv_plane: bool) -> list[tuple[str, str]]:
    """For each material of a document: "read", "rendered" or "refused", and why not more."""
    try:
        names = [node.getName() for node in materials(read_document(path))[0]]
    except UrushiError as error:
        return [("refused", str(error))]
    found = []
    for name in names:
        state = "refused"
        try:
            surface = read_surface(path, name, 8, uv_plane)
            state = "read"
            check_supported(surface)
            found.append(("rendered", ""))
        except UrushiError as error:
            found.append((state, str(error)))
    return found


def main(folder: Path, uv_plane: bool) -> None:
    mi.set_variant("scalar_rgb")
    warnings.simplefilter("ignore", UrushiWarning)
    found = [x for path in sorted(folder.rglob("*.mtlx")) for x in outcomes(path, uv_plane)]
    states = Counter(state for state, _ in found)
    read = states["read"] + states["rendered"]
    print(f"{len(found)} materials, {read} read, {states['rendered']} rendered")
    place = re.compile(r"^.*?: (the node .*?\): )?")
    reasons = Counter(f"{state}: {place.sub('', why)}" for state, why in found if why)
    for reason, count in reasons.most_common():
        print(f"{count:6} {reason[:200]}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), "--uv-plane" in sys.argv[2:])
