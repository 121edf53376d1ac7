"""What a daemon in simulated time stands up to, measured → docs/reliability.md.

python scripts/reliability.py [PART or TRIAL …] [--trials N | --quick] [--write]
All of it takes hours; --quick makes a tenth of every number. Tests that are run keep their logs in
--logs. With --write what was measured joins docs/reliability.json, from which the page is made.
"""

from __future__ import annotations

import argparse
import fcntl
import json
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from attacks import stopping, storing, tested, working
from attacks.page import page
from attacks.target import Effort, Figures, Trial, attacked

DOCS = Path(__file__).resolve().parents[1] / "docs"
ON_A_TARGET: dict[str, tuple[Trial, ...]] = {
    "stopping": stopping.TRIALS, "storing": storing.TRIALS, "working": working.TRIALS,
}  # fmt: skip


def measured(chosen: set[str], effort: Effort, logs: Path) -> Iterator[tuple[str, Figures]]:
    """``part.trial`` and its figures, as they come; nothing chosen: everything."""
    for part, trials in ON_A_TARGET.items():
        asked = [t for t in trials if not chosen or chosen & {part, t.__name__}]
        if asked:
            with attacked(effort) as target:
                for trial in asked:
                    _say(trial.__name__)
                    yield f"{part}.{trial.__name__}", _noted(trial, trial(target))
    for part, run in tested.PARTS.items():
        if not chosen or part in chosen:
            _say(part)
            for kind, figures in run(effort, logs).items():
                yield f"{part}.{kind}", _noted(run, figures)


def _noted(trial: object, figures: Figures) -> Figures:
    """With what was done, and what this and others asked of the machine meanwhile."""
    what = " ".join((trial.__doc__ or "").split())
    return {"what": what, **figures, "load": round(os.getloadavg()[1], 1)}


def _say(name: str) -> None:
    print(f"{name} …", file=sys.stderr, flush=True)


def _keep(name: str, figures: Figures) -> None:
    """With those of the other parts, at once: what comes later may fail, and parts may run side
    by side."""
    with (DOCS / "reliability.json").open("a+", encoding="utf-8") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        file.seek(0)
        found = json.loads(file.read() or "{}") | {name: figures}
        file.truncate(0)
        file.write(json.dumps(dict(sorted(found.items())), indent=1, ensure_ascii=False) + "\n")
        _write_page(found)


def _write_page(found: dict[str, Figures]) -> None:
    (DOCS / "reliability.md").write_text(page(found), encoding="utf-8")


def main() -> None:
    """All parts, or those named."""
    names = [*ON_A_TARGET, *(t.__name__ for ts in ON_A_TARGET.values() for t in ts), *tested.PARTS]
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "chosen", nargs="*", metavar="PART", help=f"of {', '.join(names)} (default: all)"
    )
    parser.add_argument("--trials", type=int, help="of each kind, instead of the usual number")
    parser.add_argument(
        "--only", default="simulated", metavar="WORDS",
        help="which kills and suspensions, as pytest's -k: 'simulated and worker' (default: all "
        "in simulated time; 'real': in real time)",
    )  # fmt: skip
    parser.add_argument("--quick", action="store_true", help="a tenth of the usual numbers")
    parser.add_argument("--write", action="store_true", help="docs/reliability.json and .md")
    parser.add_argument("--logs", type=Path, default=Path(tempfile.gettempdir()) / "pa10d-attacks")
    parser.add_argument("--page", action="store_true", help="only the page, of kept figures")
    given = parser.parse_args()
    if given.page:
        _write_page(json.loads((DOCS / "reliability.json").read_text(encoding="utf-8")))
        return
    if unknown := set(given.chosen) - set(names):
        parser.error(f"{', '.join(sorted(unknown))}: expected some of {', '.join(names)}")
    found: dict[str, Figures] = {}
    effort = Effort(0.1 if given.quick else 1.0, given.trials, given.only)
    for name, figures in measured(set(given.chosen), effort, given.logs):
        found[name] = figures
        print(json.dumps({name: figures}, ensure_ascii=False), file=sys.stderr, flush=True)
        if given.write:
            _keep(name, figures)
    print(json.dumps(found, indent=1, ensure_ascii=False))


if __name__ == "__main__":
    main()
