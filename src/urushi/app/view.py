"""`urushi view`: a page in the browser on which a material is coated by hand, and its server."""

import contextlib
import gzip
import mimetypes
import tempfile
import webbrowser
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from urushi.app.describe import describe, is_description
from urushi.app.encode import choose, read_material, scene_and_bsdf, scene_bsdfs
from urushi.errors import FileError
from urushi.files import atomic_write, new_folder, tensor_file_kind
from urushi.ranges import Port

if TYPE_CHECKING:
    from urushi.app.page_files import First


@dataclass(frozen=True)
class View:
    """Open an interactive page for designing coats in the browser.

    The page is served to this machine only, until Ctrl-C. All computation runs in the browser. With
    --output, the page is written into a folder for a web server instead, or into one self-contained
    document.

    Example: urushi view "coat(conductor(0.2, r0=(0.98, 0.77, 0.34)), alpha=0.05, sigma_t=0.3)"

    Example: urushi view lacquer.safetensors

    Example: urushi view scene.xml#varnish

    Example: urushi view -o site

    Example: urushi view lacquer.safetensors -o lacquer.html
    """

    material: tyro.conf.Positional[str | None] = None
    """Material to begin with: a description as in Python, a material file, a latent texture, a
    measured BRDF (MERL or RGL), or a BSDF of a Mitsuba scene file, SCENE.xml#ID. Default: one of
    the page's own."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Folder to write the page into, instead of serving it; or a single document (.html)."""
    port: Port = 0
    """Port to serve it at. Default: a free one."""
    no_browser: bool = False
    """Print the address only, and open no browser."""
    weights: str | None = None
    """Weights file. Default: the shipped ones."""

    def run(self) -> int:
        from urushi.app.page_files import addressed, page_document, page_files
        from urushi.nets.weights import find

        shown = None if self.material is None else first_material(self.material, self.weights)
        files = page_files(find(self.weights), shown)
        if self.output is not None:
            if self.output.suffix.lower() == ".html":
                write({self.output.name: page_document(files).encode()}, self.output.parent)
            else:
                write(addressed(files), self.output)
            print(self.output)
            return 0
        try:
            server = PageServer(addressed(files), self.port)
        except OSError as error:
            raise FileError(
                f"cannot serve the page on port {self.port}: {error}; leave out --port"
            ) from error
        with server, contextlib.suppress(KeyboardInterrupt):
            print(f"{server.url} (end with Ctrl-C)", flush=True)
            if not self.no_browser:
                webbrowser.open(server.url)
            server.serve_forever()
        return 0


def first_material(source: Any, weights: str | None) -> "First":
    """A material for the page: cards if it is described, otherwise codes or a texture.

    source: an argument of the command, a `Material`, or what `urushi.encode` takes.
    """
    import urushi
    from urushi.app.page_files import First, cards_of, first_of

    if isinstance(source, urushi.Material):
        return first_of(source, "Material")
    if not isinstance(source, str) or is_description(source):
        described = describe(source) if isinstance(source, str) else source
        cards = cards_of(described)
        return First(cards) if cards else first_of(urushi.encode(described, weights), "Material")
    path, bsdf = scene_and_bsdf(source)
    if path.suffix == ".xml":
        return _first_of_scene(path, bsdf, weights)
    if tensor_file_kind(source) == "texture":
        return _first_texture(path, path.stem, weights)
    return first_of(read_material(source, weights), path.stem)


def _first_of_scene(path: Path, bsdf: str | None, weights: str | None) -> "First":
    """The BSDF of a scene file; `bsdf`: its id, or None for the only one."""
    import urushi
    from urushi.app.page_files import first_of
    from urushi.mitsuba.reading.probing import known_surface

    chosen = choose(scene_bsdfs(path), bsdf, path)
    name = bsdf or path.stem
    latents = known_surface(chosen).latents
    if latents is not None and latents.material is None:  # codes of texels, or along axes
        with tempfile.TemporaryDirectory() as folder:
            saved = Path(folder, "texture.safetensors")
            chosen.save(saved)
            return _first_texture(saved, name, weights)
    return first_of(urushi.encode(chosen, weights), name)


def _first_texture(path: Path, name: str, weights: str | None) -> "First":
    """The texture of codes of a file, of the weights that the page has."""
    from urushi.app.page_files import First
    from urushi.nets.weights import find
    from urushi.textures.store import read_texture

    read_texture(path, find(weights))  # refuses textures that the page could not read
    texture = path.read_bytes()
    bottom = {"kind": "texels", "texture": f"{zlib.crc32(texture):08x}"}
    return First({"name": name, "bottom": bottom, "coats": []}, texture)


def write(files: dict[str, bytes], folder: Path) -> None:
    """Write files into a folder, which is made if it is missing; FileError if that fails."""
    for name, content in files.items():
        path = folder / name
        new_folder(path.parent)
        with atomic_write(path) as temporary:
            temporary.write_bytes(content)


#: The only address: other machines cannot reach it.
HOST = "127.0.0.1"

#: Content policy: a browser may load the page's own files only.
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; "
    "connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)

HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Vary": "Accept-Encoding",
    "Cache-Control": "no-cache",
}

TYPES = {".js": "text/javascript", ".svg": "image/svg+xml", ".json": "application/json"}


class PageServer(ThreadingHTTPServer):
    """Serves files by their paths, "index.html" at the root, and nothing else.

    Requests that name another host are refused, so that a foreign page cannot read the files by a
    name that it points to this machine. Files are compressed by gzip for browsers that accept it.
    """

    daemon_threads = True

    def __init__(self, files: Mapping[str, bytes], port: int = 0):
        """Bind to the port, 0: a free one; OSError if it is taken."""
        super().__init__((HOST, port), _Handler)
        self.files = files
        self.compressed = cache(lambda path: gzip.compress(files[path], mtime=0))

    @property
    def url(self) -> str:
        return f"http://{HOST}:{self.server_port}/"


class _Handler(BaseHTTPRequestHandler):
    server: PageServer
    protocol_version = "HTTP/1.1"  # one connection for several files

    def do_GET(self) -> None:
        port = self.server.server_port
        if self.headers.get("Host") not in (f"{HOST}:{port}", f"localhost:{port}"):
            self.send_error(HTTPStatus.FORBIDDEN)
            return
        path = self.path.partition("?")[0].removeprefix("/") or "index.html"
        if path not in self.server.files:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        content, headers = self.server.files[path], dict(HEADERS)
        if "gzip" in self.headers.get("Accept-Encoding", ""):
            content = self.server.compressed(path)
            headers["Content-Encoding"] = "gzip"
        suffix = path[path.rfind(".") :]
        kind = TYPES.get(suffix) or mimetypes.guess_type(path)[0] or "application/octet-stream"
        kind += "; charset=utf-8" * kind.startswith("text/")
        headers |= {"Content-Type": kind, "Content-Length": str(len(content))}
        self.send_response(HTTPStatus.OK)
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()
        if self.command == "GET":
            with contextlib.suppress(ConnectionError):  # the browser has gone away
                self.wfile.write(content)

    do_HEAD = do_GET  # without the content

    def log_message(self, format: str, *args: object) -> None:
        """Print nothing."""
