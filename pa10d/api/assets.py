"""What the page is made of: compressed, and kept by the browser for as long as it stays the same.

The page asks for its parts under a name that changes with any of them, so a part that was fetched
once is never asked for again; the page itself is asked for every time.
"""

from __future__ import annotations

import gzip
import hashlib
import mimetypes
import os
import re
from dataclasses import dataclass, field
from importlib.resources import files
from pathlib import Path

WEB = Path(__file__).resolve().parent.parent / "web"
PAGE = "index.html"
PACKAGED = {
    "plotly.js": ("pa10d.figures", "vendor/plotly.js"),
    "plots.js": ("pa10d.figures", "plots.js"),
}
PACKED = ".gz"  # of files that lie there compressed
IMPORTED = re.compile(r'^import (?:[^;"]*? from )?"(\./[^"]+|\.\./[^"]+)"', re.MULTILINE)
SMALL = 1000  # bytes: less is not worth compressing
LEVEL = 6

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

    _known: dict[str, tuple[tuple[int, int], Asset]] = field(default_factory=dict)

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
        """The page, which asks for parts of this version; those that its script will ask for are
        named at once, so that a slow link is not waited for once per level of imports."""
        text = (WEB / PAGE).read_text(encoding="utf-8")
        links = [f'<link rel="modulepreload" href="assets/VERSION/{name}">' for name in needed()]
        return text.replace("</body>", "\n".join([*links, "</body>"])).replace(
            "VERSION", self.version()
        )

    def get(self, name: str) -> Asset | None:
        """One file; None for what the page does not have. The first time it is compressed."""
        path = self.names().get(name)
        if path is None:
            return None
        stamp = _stamp(path)
        known = self._known.get(name)
        if known is None or known[0] != stamp:
            known = self._known[name] = (stamp, _read(path))
        return known[1]


def needed(script: str = "main.js") -> list[str]:
    """Every module that a script imports before it runs, however deep, in the order of need."""
    found: list[str] = []
    waiting = [script]
    while waiting:
        name = waiting.pop(0)
        if name in found or not (WEB / name).is_file():
            continue
        found.append(name)
        folder = Path(name).parent
        text = (WEB / name).read_text(encoding="utf-8")
        waiting += [os.path.normpath(folder / said) for said in IMPORTED.findall(text)]
    return found


def _stamp(path: Path) -> tuple[int, int]:
    found = path.stat()
    return found.st_mtime_ns, found.st_size


def _read(path: Path) -> Asset:
    stored = path.read_bytes()
    packed: bytes | None = stored
    if path.suffix == PACKED:
        plain = gzip.decompress(stored)
    else:
        plain = stored
        packed = gzip.compress(plain, LEVEL, mtime=0) if len(plain) > SMALL else None
    media = mimetypes.guess_type(path.name.removesuffix(PACKED))[0] or "application/octet-stream"
    return Asset(plain, packed if packed and len(packed) < len(plain) else None, media)
