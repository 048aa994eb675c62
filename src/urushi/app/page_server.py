"""A server of a few files in memory, for this machine alone."""

import contextlib
import gzip
import mimetypes
from collections.abc import Mapping
from functools import cache
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from urushi.app.page_files import version

#: The only address: other machines cannot reach it.
HOST = "127.0.0.1"

#: What a browser may load for the page: its own files.
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
}

#: What a browser does with an answer that it has: asks whether it is still right; or, where the
#: address names the version of the content, uses it.
ASK, KEEP = "no-cache", "private, max-age=31536000, immutable"

TYPES = {".js": "text/javascript", ".svg": "image/svg+xml", ".json": "application/json"}


class PageServer(ThreadingHTTPServer):
    """Serves files by their paths, "index.html" at the root, and nothing else.

    Requests that name another host are refused, so that a foreign page cannot read the files by a
    name that it points to this machine. Files are compressed by gzip for browsers that accept it,
    and answered by 304 if the browser has them.
    """

    daemon_threads = True

    def __init__(self, files: Mapping[str, bytes], port: int = 0):
        """Bind to the port, 0: a free one; OSError if it is taken."""
        super().__init__((HOST, port), _Handler)
        self.files = files
        self.versions = {path: version(content) for path, content in files.items()}
        self.compressed = cache(lambda path: gzip.compress(files[path], mtime=0))

    @property
    def url(self) -> str:
        return f"http://{HOST}:{self.server_port}/"


class _Handler(BaseHTTPRequestHandler):
    server: PageServer
    protocol_version = "HTTP/1.1"  # one connection for several files

    def do_GET(self) -> None:
        self._answer(with_body=True)

    def do_HEAD(self) -> None:
        self._answer(with_body=False)

    def _answer(self, with_body: bool) -> None:
        port = self.server.server_port
        if self.headers.get("Host") not in (f"{HOST}:{port}", f"localhost:{port}"):
            self.send_error(HTTPStatus.FORBIDDEN)
            return
        path, _, query = self.path.partition("?")
        path = path.removeprefix("/") or "index.html"
        if path not in self.server.files:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        content, headers = self.server.files[path], dict(HEADERS)
        if "gzip" in self.headers.get("Accept-Encoding", ""):
            content = self.server.compressed(path)
            headers["Content-Encoding"] = "gzip"
        known = self.server.versions[path]
        headers["ETag"] = f'W/"{known}"'
        headers["Cache-Control"] = KEEP if query == known else ASK
        is_known = headers["ETag"] == self.headers.get("If-None-Match")
        self.send_response(HTTPStatus.NOT_MODIFIED if is_known else HTTPStatus.OK)
        if not is_known:
            headers |= {"Content-Type": _type(path), "Content-Length": str(len(content))}
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()
        if with_body and not is_known:
            with contextlib.suppress(ConnectionError):  # the browser has gone away
                self.wfile.write(content)

    def log_message(self, format: str, *args: object) -> None:
        """Print nothing."""


def _type(path: str) -> str:
    suffix = path[path.rfind(".") :]
    kind = TYPES.get(suffix) or mimetypes.guess_type(path)[0] or "application/octet-stream"
    return f"{kind}; charset=utf-8" if kind.startswith("text/") else kind
