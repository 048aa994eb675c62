"""The files of the page: the built page, the weights, shader code, films, what it shows first.

The page is built from the folder `viewer` of the repository by `make viewer`. The layering network
is in half precision, the functions of the basis in fixed point. The page inserts the codes of its
materials into shader code of `urushi export`.
`page_document` puts all files into one HTML document, for notebooks.
"""

import base64
import gzip
import hashlib
import json
import re
import tempfile
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import safetensors.numpy

from urushi.checks import AIR, Widths
from urushi.core.table import SHAPE, node_pairs, table_of_values
from urushi.errors import FileError, ParameterError
from urushi.export.languages import LANGUAGES
from urushi.export.program import template_text
from urushi.files import METADATA_KEY
from urushi.material import Material, encode
from urushi.nets.weights import FORMAT_VERSION, Model, anisotropic_model
from urushi.openpbr_surface.thin_film import MEAN_COSINE, FilmedMetal
from urushi.walk import Stack, conductor

#: The folder of the built page.
BUILT = Path(__file__).with_name("page")

#: Names of the files that are made, not built.
WEIGHTS_FILE, START_FILE, SHADERS_FOLDER = "weights.safetensors", "start.json", "shaders"
ANISOTROPIC_FILE = "anisotropic.safetensors"
STORED_FOLDER = "stored"
TEXTURE_FILE, TABLE_FILE = "texture.safetensors", "table.f16"

#: Step to which functions of the basis are rounded. Their codes have a mean square of one: rounding
#: adds an error E of about 0.04 %.
FUNCTION_STEP = 9e-4

#: Complex index of niobium as Mitsuba has it in its RGB variants.
_NIOBIUM = (3.42, 2.79, 2.396), (3.441, 2.738, 2.58)

#: Metals under films that the page offers, since descriptions have no films: anodised niobium, the
#: metal of coins and jewellery, whose oxide has an index of 2.3.
FILMS = {
    "anodised niobium, blue": FilmedMetal(0.15, *_NIOBIUM, ior=2.3, thickness=0.06),
    "anodised niobium, magenta": FilmedMetal(0.15, *_NIOBIUM, ior=2.3, thickness=0.16),
}

#: Coats that the page has cards for.
MOST_COATS = 6

#: Descriptions of bottoms that the page has cards for.
PAGE_BOTTOMS = ("conductor", "dielectric", "diffuse")


class First(NamedTuple):
    """The first material of the page."""

    material: dict[str, Any]  # as the page reads it; of `cards_of` or `first_of`, or texels
    texture: bytes | None = None  # the content of the file of its texture of codes, if it has one
    table: bytes | None = None  # the half numbers of its table of f, if it has one


def page_files(model: Model, first: First | None) -> dict[str, bytes]:
    """The page's files by their paths relative to it, with "/" between folders.

    model: the weights of isotropic materials; anisotropic ones have the shipped weights.
    first: None: the page's own first material.
    """
    if model.widths == 2:
        raise ParameterError(
            f"the weights {model.fingerprint} are for anisotropic materials; give --weights of "
            "networks for isotropic ones, or leave it out"
        )
    built = {
        path.relative_to(BUILT).as_posix(): path.read_bytes()
        for path in sorted(BUILT.rglob("*"))
        if path.is_file()
    }
    if "index.html" not in built:
        raise FileError(f"the page is missing in '{BUILT}'; run `make viewer` in the repository")
    start: dict[str, Any] = {} if first is None else {"materials": [first.material]}
    other = anisotropic_model()
    made = {WEIGHTS_FILE: packed_weights(model), ANISOTROPIC_FILE: packed_weights(other)}
    for kind, file in (("texture", TEXTURE_FILE), ("table", TABLE_FILE)):
        content = getattr(first, kind, None)
        if content is not None:
            start[kind], made[file] = file, content
    start["stored"] = {}
    for place, (name, metal) in enumerate(FILMS.items()):
        path = f"{STORED_FOLDER}/{place}.safetensors"
        start["stored"][name[0].upper() + name[1:]] = path
        made[path] = file_of(filmed_material(metal, model))
    made[START_FILE] = json.dumps(start).encode()
    return built | made | shader_files(model) | shader_files(other)


def filmed_material(metal: FilmedMetal, model: Model) -> Material:
    """A filmed metal: its table; and codes for coats, of a metal of its mean reflectance."""
    mean = tuple(metal.reflectance(np.array([MEAN_COSINE]))[0])
    codes = encode(conductor(metal.alpha, r0=mean), model)
    return replace(codes, table=table_of_values(metal.f(*node_pairs())))


def file_of(material: Material) -> bytes:
    """The content of a material's file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "material.safetensors")
        material.save(path)
        return path.read_bytes()


def addressed(files: Mapping[str, bytes]) -> dict[str, bytes]:
    """The files of a page for a server: its document refers to each by its path and its version.

    A browser may keep such a file without asking again, since changed content has a new address.
    Any server can serve the files, because the version is a query, "assets/index.js?3f9c…". The
    browser loads the weights together with the script, instead of after it.
    """
    versions = {path: version(content) for path, content in files.items() if path != "index.html"}
    text = re.sub(
        r'(?:href|src)="\./([^"]+)',
        lambda link: f"{link[0]}?{versions[link[1]]}",
        files["index.html"].decode(),
    )
    ahead = "".join(
        f'<link rel="preload" as="fetch" crossorigin href="./{path}?{versions[path]}">'
        for path in (START_FILE, WEIGHTS_FILE)
    )
    listed = f'<script type="application/json" id="versions">{json.dumps(versions)}</script>'
    text = text.replace("</head>", f"{ahead}{listed}</head>")
    return {**files, "index.html": text.encode()}


def version(content: bytes) -> str:
    """Identifies a file's content: the beginning of its SHA-256."""
    return hashlib.sha256(content).hexdigest()[:16]


def shader_files(model: Model) -> dict[str, bytes]:
    """The templates of `export.program.template_text`, "shaders/glsl.txt" and so on.

    Those of two widths are in "shaders/anisotropic".
    """
    folder = SHADERS_FOLDER if model.widths == 1 else f"{SHADERS_FOLDER}/anisotropic"
    return {
        f"{folder}/{language}.txt": template_text(language, model).encode()
        for language in LANGUAGES
    }


def packed_weights(model: Model) -> bytes:
    """A weights file (safetensors): the network in half precision, and the basis packed.

    What codes of values are fitted with is left out: the page encodes described surfaces only.
    """
    arrays = {
        name: array if name.startswith("basis.") else _half_precision(array)
        for name, array in model.params.items()
        if name not in ("basis.measure", "basis.prior")
    }
    arrays |= packed_rows(arrays.pop("basis.rows"), SHAPE)
    description = {
        "kind": "weights",
        "version": FORMAT_VERSION,
        "architecture": json.loads(model.arch.to_json()),
        "fingerprint": model.fingerprint,
    }
    return safetensors.numpy.save(arrays, {METADATA_KEY: json.dumps(description, sort_keys=True)})


def _half_precision(array: np.ndarray) -> np.ndarray:
    if np.abs(array).max() > float(np.finfo(np.float16).max):
        raise ParameterError("a parameter is too large for half precision")
    return array.astype(np.float16)


def packed_rows(rows: np.ndarray, shape: Sequence[int]) -> dict[str, np.ndarray]:
    """The rows (P, 1 + K) of a basis as bytes that compress well, and their step.

    Returns:
        basis.bytes: uint8 (2, K, P), low and high bytes of numbers: twice the differences, along
            all axes in turn, of multiples of the step; for those below zero, -1 minus this. They
            are of b, then of the functions without the first, which is one.
        basis.step: float32 (1,).
    """
    columns = np.delete(rows, 1, axis=1).T.astype(np.float64)
    steps = np.rint(columns / FUNCTION_STEP).astype(np.int32).reshape(-1, *shape)
    for axis in range(1, steps.ndim):
        steps = np.diff(steps, axis=axis, prepend=0)
    numbers = np.where(steps < 0, -1 - 2 * steps, 2 * steps).reshape(len(columns), -1)
    if numbers.max() >= 1 << 16:
        raise ParameterError("a function of the basis is too large for the page")
    return {
        "basis.bytes": np.stack([numbers & 255, numbers >> 8]).astype(np.uint8),
        "basis.step": np.array([FUNCTION_STEP], np.float32),
    }


def first_of(material: Material, name: str) -> First:
    """A material as the page shows it, by its table or its codes."""
    codes = np.broadcast_to(material.latents, (3, material.model.arch.latent))
    shown: dict[str, Any] = {
        "name": name,
        "bottom": {"kind": "codes", "latents": codes.ravel().tolist()},
        "coats": [],
    }
    if material.model.widths == 2:
        shown["bottom"]["widths"] = 2
        shown["rotation"] = (material.rotation + 180) % 360 - 180
    if material.table is None:
        return First(shown)
    nodes = material.table.shape[:3]
    table = np.broadcast_to(material.table, (*nodes, 3)).astype("<f2").tobytes()
    named = {"table": f"{zlib.crc32(table):08x}", "besideLobe": material.beside_lobe}
    shown["bottom"] |= named
    return First(shown, table=table)


def cards_of(described: Any) -> dict[str, Any] | None:
    """A description as the page reads it; None if the page has no cards for it."""
    coats = described.coats if isinstance(described, Stack) else ()
    bottom = described.bottom if isinstance(described, Stack) else described
    if len(coats) > MOST_COATS:
        return None
    kind = type(bottom).__name__.lower()
    if kind not in PAGE_BOTTOMS:
        return None
    above: Any = AIR  # the index of the medium above
    cards = []
    for coat in coats:
        above = np.multiply(coat.eta, above).tolist() if coat.ior is None else coat.ior
        medium = {"albedo": coat.albedo, "sigmaT": coat.sigma_t, "g": coat.g}
        cards.append({**_widths(coat.alpha), "ior": above, **medium})
    numbers = {name: value for name, value in vars(bottom).items() if value is not None}
    compensated = numbers.pop("energy_compensation", False)
    if coats and compensated:  # the page compensates the topmost surface alone
        return None
    if kind == "dielectric":
        numbers = {"ior": np.multiply(numbers.pop("eta"), above).tolist(), **numbers}
    elif "k" in numbers:
        in_air = np.divide(above, AIR)
        numbers |= {name: np.multiply(in_air, numbers[name]).tolist() for name in ("eta", "k")}
    widths = _widths(numbers.pop("alpha")) if "alpha" in numbers else {}
    shown = {"name": "Material", "bottom": {"kind": kind, **widths, **numbers}, "coats": cards}
    compensated = coats[0].energy_compensation if coats else compensated
    return {**shown, "energyCompensation": True} if compensated else shown


def _widths(alpha: Any) -> dict[str, Any]:
    """The GGX widths of a surface as the page reads them."""
    return {"alpha": alpha.u, "alphaV": alpha.v} if isinstance(alpha, Widths) else {"alpha": alpha}


#: Files that are not packed: the document contains their text, or does not need them.
_WRITTEN = ("index.html", "assets/index.js", "assets/index.css", "icon.svg", "sources.txt")


def page_document(files: Mapping[str, bytes]) -> str:
    """The document of a page's files, of `page_files`.

    The script and the style stand in it, all other files packed: each by gzip and in base64. Its
    policy allows these two only, by their hashes, and no request to anywhere.
    """
    script, style = (files[f"assets/index.{suffix}"].decode() for suffix in ("js", "css"))
    if "</script" in script or "</style" in style:
        raise FileError(
            "the built page cannot be put into one document; build it again by `make viewer`"
        )
    packed = {
        path: base64.b64encode(gzip.compress(content, mtime=0)).decode()
        for path, content in files.items()
        if path not in _WRITTEN
    }
    policy = (
        f"default-src 'none'; script-src '{_hash(script)}'; style-src '{_hash(style)}'; "
        "img-src data:; worker-src blob:; base-uri 'none'; form-action 'none'"
    )
    text = files["index.html"].decode()
    for pattern, replacement in (
        (r'content="default-src[^"]*"', f'content="{policy}"'),
        (r"<link rel=\"icon\"[^>]*>", ""),
        (r"<link rel=\"stylesheet\"[^>]*>", f"<style>{style}</style>"),
        (
            r"<script[^>]*></script>",
            f'<script type="application/json" id="files">{json.dumps(packed)}</script>'
            f'<script type="module">{script}</script>',
        ),
    ):
        parts = re.split(pattern, text)
        if len(parts) != 2:
            raise FileError("the built page has an unknown form; build it again by `make viewer`")
        text = replacement.join(parts)
    return text


def _hash(text: str) -> str:
    """The source of a policy for a script or a style that stands in a document."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
