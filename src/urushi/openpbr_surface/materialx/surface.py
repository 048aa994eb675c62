"""Materials of documents: their surface shaders, and mixtures of shaders."""

import os
from collections.abc import Iterator
from typing import Any

from urushi.checks import Check
from urushi.errors import FileError
from urushi.openpbr_surface.materialx.baking import MAX_RESOLUTION, bake, changes
from urushi.openpbr_surface.materialx.document import find_material, read_document
from urushi.openpbr_surface.materialx.graph import Frame, Graph, Source
from urushi.openpbr_surface.materialx.images import Images
from urushi.openpbr_surface.materialx.reader import Mix, Reader, Surface, mixed, warn

#: Rows and columns of a texture that is computed on a grid, unless another number is asked for.
RESOLUTION = 1024

#: The numbers that may be asked for.
RESOLUTIONS = Check("resolution", f"in [1, {MAX_RESOLUTION}]", 1, MAX_RESOLUTION)

#: Inputs of a material that are left out, and their names in warnings.
_LOST_SHADERS = {"displacementshader": "displacement", "backsurfaceshader": "back's shader"}

#: Largest number of shaders in a mixture.
MAX_MIXED = 16


def read_surface(
    path: str | os.PathLike,
    name: str | None = None,
    resolution: int = RESOLUTION,
    uv_plane: bool = False,
) -> Surface | Mix:
    """Read a material of a document; see `plugins.materialx.load_materialx`."""
    resolution = int(RESOLUTIONS(resolution))
    document = read_document(path)
    material = find_material(document, name)
    name = material.getName()
    where = f"{document.where}: '{name[:60]}'"
    images = Images(document.path.parent)
    graph = Graph(document.root, images, document.where, uv_plane=uv_plane)
    try:
        shader = _find_shader(graph, material, where)
        return _read(graph, shader, resolution, name, iter(range(MAX_MIXED)))
    except RecursionError:
        raise FileError(f"{where} has nodes nested too deeply; simplify it") from None


def _read(
    graph: Graph, shader: Source, resolution: int, name: str, left: Iterator[int]
) -> Surface | Mix:
    """The material of a shader, or the mixture of two.

    name: the material's. left: has an item for every further shader that is allowed.
    """
    node, named = shader.element, graph.named(shader.element)
    where = f"{graph.where}: '{name[:60]}'"
    if next(left, None) is None:
        raise FileError(
            f"{where} mixes more than {MAX_MIXED} surface shaders; mix the inputs of one shader "
            "instead, or bake the material into images"
        )
    if node.getCategory() != "mix":
        return Reader(graph, shader, resolution, where).material(name)

    def part(side: str) -> Surface | Mix:
        source = _shader(graph, node, side, shader.frame, f"{named}: its {side}")
        return _read(graph, source, resolution, name, left)

    weight = bake(graph, lambda e: e.input(node, "mix", shader.frame), resolution, f"{named}: mix")
    return mixed(name, weight, f"{named}: mix", part)


def _shader(graph: Graph, node: Any, name: str, frame: Frame, where: str) -> Source:
    """The shader to which an input of a node is connected."""
    link = node.getInput(name)
    return _node(None if link is None else graph.follow(link, frame, node), where)


def _node(found: Source | None, where: str) -> Source:
    if found is None or not found.is_node:
        raise FileError(f"{where} is connected to no surface shader in the document")
    return found


def _find_shader(graph: Graph, material: Any, where: str) -> Source:
    """The surface shader of a material, or of a shader's graph."""
    frame, scope = graph.root, material.getParent()
    if scope.getCategory() == "nodegraph":
        frame = graph.inside(scope, frame) or frame
    if material.getCategory() != "surfacematerial":
        inner = graph.inside(material, frame)
        outputs = [] if inner is None else inner.scope.getOutputs()
        if inner is None or not outputs:
            return Source(material, frame)
        return _node(graph.follow(outputs[0], inner, material), where)
    for name, part in _LOST_SHADERS.items():
        element = material.getInput(name)
        source = None if element is None else graph.follow(element, frame, material)
        if source is not None and source.is_node and not _is_flat(graph, source):
            warn(f"{where}: its {part} is left out; OpenPBR describes the front's surface")
    return _shader(graph, material, "surfaceshader", frame, where)


def _is_flat(graph: Graph, source: Source) -> bool:
    """Whether a node displaces by nothing."""
    node, name = source.element, "displacement"
    return node.getCategory() == name and not changes(
        graph, lambda e: e.input(node, name, source.frame)
    )
