"""Scripts that the page takes from installed packages: nothing comes from outside."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from fastapi import APIRouter
from fastapi.responses import FileResponse

from pa10d.api.problems import Problem

router = APIRouter(prefix="/scripts", include_in_schema=False)
SCRIPTS = {
    "plotly.js": ("plotly", "package_data/plotly.min.js"),
    "plots.js": ("pa10d.figures", "plots.js"),
}


@router.get("/{name}")
async def script(name: str) -> FileResponse:
    """One script."""
    if name not in SCRIPTS:
        raise Problem("not-found", f"no script {name[:60]!r}")
    package, path = SCRIPTS[name]
    return FileResponse(Path(str(files(package) / path)), media_type="text/javascript")
