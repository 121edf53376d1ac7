"""Fetch the foreign libraries of page and figures from npm, with their licences.

    python scripts/vendor.py

Needs npm. Versions are pinned here; what it writes is kept in the repository, so that nothing is
fetched where pa10d is installed or runs. Only what is used of each library is bundled: for the
figures that is the bundle of plotly.js that has their traces. Then: ``scripts/sbom.py``.
"""

from __future__ import annotations

import gzip
import json
import shutil
import subprocess
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent
WEB, TESTS = HERE / "pa10d/web/vendor", HERE / "tests/web/vendor"
FIGURES = HERE / "pa10d/figures/vendor"
BUNDLER = "esbuild@0.25.12"
VERSIONS = {"three": "0.187.0", "uplot": "1.6.32", "@uwdata/flechette": "2.2.5"}
AXE = ("axe-core", "4.14.1")  # for tests only
PLOTLY = ("plotly.js-cartesian-dist-min", "4.1.1")
BUNDLES = {
    "three": """
export {
  BufferAttribute, BufferGeometry, CapsuleGeometry, Color, CylinderGeometry, DirectionalLight,
  DoubleSide, GridHelper, Group, HemisphereLight, Line, LineBasicMaterial, Mesh,
  MeshLambertMaterial, PerspectiveCamera, Quaternion, Scene, SphereGeometry, Vector3,
  WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
""",
    "uplot": 'export { default as uPlot } from "uplot";',
    "arrow": 'export { tableFromIPC } from "@uwdata/flechette";',
}
PACKAGES = {"three": "three", "uplot": "uplot", "arrow": "@uwdata/flechette"}
FILES = {"uplot.css": "uplot/dist/uPlot.min.css"}


def main() -> None:
    """All of it."""
    WEB.mkdir(exist_ok=True)
    TESTS.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        modules = place / "node_modules"
        wanted = [f"{name}@{version}" for name, version in [*VERSIONS.items(), AXE, PLOTLY]]
        (place / "package.json").write_text("{}")
        subprocess.run(["npm", "install", "--silent", BUNDLER, *wanted], cwd=place, check=True)
        for name, entry in BUNDLES.items():
            (place / f"{name}.js").write_text(entry)
            command = [next(modules.glob("@esbuild/*/bin/esbuild")), f"{name}.js", "--bundle"]
            command += ["--minify", "--format=esm", "--legal-comments=none"]
            made = subprocess.run(command, cwd=place, check=True, capture_output=True).stdout
            write(WEB / f"{name}.js.gz", made)
        for name, source in FILES.items():
            write(WEB / f"{name}.gz", (modules / source).read_bytes())
        shutil.copy(modules / PLOTLY[0] / "plotly-cartesian.min.js", FIGURES / "plotly.js")
        shutil.copy(modules / PLOTLY[0] / "LICENSE", FIGURES / "LICENCE")
        write_list(FIGURES, modules, {"plotly.js": PLOTLY[0]})
        write_list(
            WEB,
            modules,
            {f"{name}.js.gz": PACKAGES[name] for name in BUNDLES}
            | {f"{name}.gz": source.split("/")[0] for name, source in FILES.items()},
        )
        (WEB / "LICENCES").write_text(
            "\n\n".join(
                f"{name} {version}\n\n{(modules / name / 'LICENSE').read_text().strip()}"
                for name, version in VERSIONS.items()
            )
            + "\n"
        )
        write(TESTS / "axe.min.js.gz", (modules / AXE[0] / "axe.min.js").read_bytes())
        (TESTS / "LICENSE").write_text((modules / AXE[0] / "LICENSE").read_text())


def write_list(folder: Path, modules: Path, files: dict[str, str]) -> None:
    """``vendored.json``: which package and version each file comes from, and its licence."""
    listed = []
    for file, package in files.items():
        about = json.loads((modules / package / "package.json").read_text())
        listed.append(
            {"name": package, "version": about["version"], "licence": about["license"],
             "file": file}
        )  # fmt: skip
    (folder / "vendored.json").write_text(json.dumps(listed, indent=1) + "\n")


def write(path: Path, content: bytes) -> None:
    """Compressed, the same bytes every time."""
    path.write_bytes(gzip.compress(content, 9, mtime=0))
    print(f"{path.relative_to(HERE)}: {path.stat().st_size} bytes of {len(content)}")


if __name__ == "__main__":
    main()
