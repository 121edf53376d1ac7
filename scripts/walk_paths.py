"""Walks the first paths of the docs by their text alone: every shell block, in order.

    python scripts/walk_paths.py FOLDER [PATH …]

The ``pa10d`` and ``python3`` of PATH (the variable) are used, so an installed wheel is tried by
putting its environment first. Each path has a folder of its own.
"""

from __future__ import annotations

import re
import subprocess
import sys
import time
from pathlib import Path

DOCS = Path(__file__).resolve().parent.parent / "docs"
PATHS = ("start-csv", "start-bag", "start-virtual-arm")
LONGEST = 600.0  # s: ten minutes each is the promise


def walk(path: str, folder: Path) -> float:
    """Seconds that it took; CalledProcessError where a block fails."""
    folder.mkdir(parents=True)
    text = (DOCS / f"{path}.md").read_text(encoding="utf-8")
    script = "\n".join(re.findall(r"^```sh\n(.*?)^```", text, re.MULTILINE | re.DOTALL))
    began = time.monotonic()
    subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=folder, check=True)
    return time.monotonic() - began


def main() -> None:
    """All of them, or those that are named."""
    place = Path(sys.argv[1])
    for path in sys.argv[2:] or PATHS:
        took = walk(path, place / path)
        print(f"{path}: {took:.0f} s", flush=True)
        if took > LONGEST:
            sys.exit(f"{path}: more than {LONGEST:.0f} s")


if __name__ == "__main__":
    main()
