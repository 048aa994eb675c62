"""Materials of documents: their surface shaders, and mixtures of shaders."""

import os
from collections.abc import Iterator
from functools import partial
from typing import Any

from urushi.checks import Check
from urushi.errors import FileError
from urushi.openpbr_surface.materialx.baking import MAX_RESOLUTION, bake, changes
from urushi.openpbr_surface.materialx.document import find_material, read_document
from urushi.openpbr_surface.materialx.evaluation import Evaluation
from urushi.openpbr_surface.materialx.graph import Frame, Graph, Node, Source, library
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
    document.root.setDataLibrary(library())
    root = Frame(document.root, document.where)
    graph = Graph(root, Images(document.path.parent), uv_plane)
    try:
        shader = _shader_of(graph, material, where)
        return _read(graph, shader, resolution, name, where, iter(range(MAX_MIXED)))
    except RecursionError:
        raise FileError(f"{where} has nodes nested too deeply; simplify it") from None


def _read(
    graph: Graph, shader: Node, resolution: int, name: str, where: str, left: Iterator[int]
) -> Surface | Mix:
    """The material of a shader, or the mixture of two.

    name: the material's. left: has an item for every further shader that is allowed.
    """
    if next(left, None) is None:
        raise FileError(
            f"{where} mixes more than {MAX_MIXED} surface shaders; mix the inputs of one shader "
            "instead, or bake the material into images"
        )
    if shader.tag != "mix":
        return Reader(graph, shader, resolution, where).material(name)

    def part(side: str) -> Surface | Mix:
        return _read(graph, _connected(shader, side), resolution, name, where, left)

    weight = bake(graph, lambda e: e.input(shader, "mix"), resolution, f"{shader.where}: mix")
    return mixed(name, weight, f"{shader.where}: mix", part)


def _connected(node: Node, name: str) -> Node:
    """The shader to which an input of a node is connected."""
    return _shader(node.source(name), f"{node.where}: its {name}")


def _shader(source: Source | None, where: str) -> Node:
    if source is None or source.node is None:
        raise FileError(f"{where} is connected to no surface shader in the document")
    return source.node


def _shader_of(graph: Graph, element: Any, where: str) -> Node:
    """The surface shader of a material, or of a shader's graph."""
    nested = graph.root.node(element.getParent().getName())
    node = ((nested and nested.inside) or graph.root).node(element.getName())
    assert node is not None
    if node.tag != "surfacematerial":
        outputs = node.inside.scope.getOutputs() if node.inside else []
        if not node.inside or not outputs:
            return node
        return _shader(node.inside.follow(outputs[0], node.where), where)
    for name, part in _LOST_SHADERS.items():
        given = node.source(name)
        lost = None if given is None else given.node
        if lost is None:
            continue
        displaced = partial(Evaluation.input, node=lost, name="displacement")
        if lost.tag != "displacement" or changes(graph, displaced):
            warn(f"{where}: its {part} is left out; OpenPBR describes the front's surface")
    return _connected(node, "surfaceshader")
