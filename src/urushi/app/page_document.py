"""The page as a single HTML document, for notebooks and for files that are passed on."""

import base64
import gzip
import hashlib
import json
import re
from collections.abc import Mapping

from urushi.errors import FileError

#: Files that stand in the document as they are, or are of no use in it.
_WRITTEN = ("index.html", "assets/index.js", "assets/index.css", "icon.svg", "sources.txt")


def page_document(files: Mapping[str, bytes]) -> str:
    """The document of a page's files, of `page_files`.

    The script and the style stand in it, all other files packed: each by gzip and in base64. Its
    policy allows these two only, by their hashes, and no request to anywhere.

    Raises:
        FileError: the page was built in another way.
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
