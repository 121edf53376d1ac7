"""A report in the browser: a file that draws its plots by scripts of its own, and may do no more.

What is written in it comes from names and files of others. It gets an origin of its own, so that
nothing in it can speak for whoever reads it, and may fetch nothing.
"""

from __future__ import annotations

from pathlib import Path

from fastapi.responses import FileResponse

_ALONE = {
    "content-security-policy": (
        "sandbox allow-scripts allow-downloads allow-popups; default-src 'none'; "
        "script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
        "font-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "unsafe-none",  # goes with no sandbox
}


def report_file(path: Path) -> FileResponse:
    """HTML that opens without a network, as an answer."""
    return FileResponse(path, media_type="text/html; charset=utf-8", headers=_ALONE)
