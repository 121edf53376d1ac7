"""What the page is made of: compressed, and kept by the browser for as long as it stays the same.

The page asks for its parts under a name that changes with any of them, so a part that was fetched
once is never asked for again; the page itself is asked for every time.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import mimetypes
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path

from pa10d.api import packs

WEB = Path(__file__).resolve().parent.parent / "web"
PAGE = "index.html"
PACKAGED = {
    "plotly.js": ("pa10d.figures", "vendor/plotly.js"),
    "plots.js": ("pa10d.figures", "plots.js"),
}
PACKED = ".gz"  # of files that lie there compressed
SMALL = 1000  # bytes: less is not worth compressing
LEVEL = 9
# Asks for the section in the address while the page is still read; any other word means "robot".
AHEAD = """
{
  const [, section] = location.hash.match(/^#\\/(\\w+)/) ?? [null, "robot"];
  const link = document.createElement("link");
  link.rel = "modulepreload";
  link.href = `${document.documentElement.dataset.parts}packs/sections/${section}.js`;
  document.head.append(link);
}
"""
AHEAD_HASH = base64.b64encode(hashlib.sha256(AHEAD.encode()).digest()).decode()

mimetypes.add_type("text/javascript", ".js")


@dataclass(frozen=True)
class Asset:
    """One file as it goes out. packed: gzip, where that is smaller."""

    plain: bytes
    packed: bytes | None
    media_type: str


@dataclass
class Assets:
    """Files by the names that the page uses for them, read again when they have changed."""

    _known: dict[str, tuple[object, Asset]] = field(default_factory=dict)

    def names(self) -> dict[str, Path]:
        """Name -> file."""
        found = [path for path in WEB.rglob("*.*") if path.is_file()]
        own = {str(path.relative_to(WEB)).removesuffix(PACKED): path for path in found}
        packaged = {name: Path(str(files(p) / path)) for name, (p, path) in PACKAGED.items()}
        return {name: path for name, path in sorted((own | packaged).items()) if name != PAGE}

    def version(self) -> str:
        """Another one as soon as any file is another."""
        stamps = [(name, *_stamp(path)) for name, path in self.names().items()]
        return hashlib.sha256(repr(stamps).encode()).hexdigest()[:12]

    def page(self) -> str:
        """The page, which asks for parts of this version."""
        text = (WEB / PAGE).read_text(encoding="utf-8")
        return text.replace("<!-- AHEAD -->", f"<script>{AHEAD}</script>").replace(
            "VERSION", self.version()
        )

    def get(self, name: str) -> Asset | None:
        """One file; None for what the page does not have. The first time it is compressed."""
        names = self.names()
        script = name.removeprefix(packs.FOLDER)
        path = names.get(script)
        packed = script != name and path == WEB / script and path.suffix == ".js"
        if path is None or (script != name and not packed):
            return None
        stamp = self.version() if packed else _stamp(path)
        known = self._known.get(name)
        if known is None or known[0] != stamp:
            made = _asset(packs.pack(script, _text).encode(), path) if packed else _read(path)
            known = self._known[name] = (stamp, made)
        return known[1]


def _text(name: str) -> str:
    return (WEB / name).read_text(encoding="utf-8")


def _stamp(path: Path) -> tuple[int, int]:
    found = path.stat()
    return found.st_mtime_ns, found.st_size


def _read(path: Path) -> Asset:
    stored = path.read_bytes()
    if path.suffix == PACKED:
        return _asset(gzip.decompress(stored), path, stored)
    return _asset(stored, path)


def _asset(plain: bytes, path: Path, packed: bytes | None = None) -> Asset:
    if packed is None and len(plain) > SMALL:
        packed = gzip.compress(plain, LEVEL, mtime=0)
    media = mimetypes.guess_type(path.name.removesuffix(PACKED))[0] or "application/octet-stream"
    return Asset(plain, packed if packed and len(packed) < len(plain) else None, media)
