"""Several files as one answer."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping

from pa10d.common.jsonable import JsonObject

MEDIA = "application/zip"
DOCUMENTED: dict[int | str, JsonObject] = {
    200: {"content": {MEDIA: {"schema": {"type": "string", "format": "binary"}}}}
}
"""For the responses of a route."""


def packed(files: Mapping[str, str]) -> bytes:
    """A folder as one zip file; the same files, the same bytes."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            archive.writestr(zipfile.ZipInfo(name), files[name], zipfile.ZIP_DEFLATED)
    return out.getvalue()
