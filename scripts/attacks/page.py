"""The figures as ``docs/reliability.md``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from attacks.target import Figures

INTRODUCTION = """# Reliability

Made by `python scripts/reliability.py --write`: a daemon with a virtual arm in simulated time,
attacked. `python scripts/reliability.py --help` lists the parts; each can be run by itself, as
often as wanted (`kills --trials 30`), and keeps the other parts' figures on this page. Beside every
figure stands the load of the machine while it was made (two processors, shared with others): a
load above 2 means that processes waited for each other.
"""

STOPS = """## How soon `stop` is answered

The aim: within 100 ms whatever the store, the workers or a client do, on a machine that does
nothing else. Each time is one request on a connection of its own, without waiting for the arm's
rest (`?wait=SECONDS` does).

| while … | requests | median, ms | 99 % | longest | load | besides |
|---|---|---|---|---|---|---|"""

KILLS = """## A process is killed while the arm moves

Each at a moment drawn between 0 and 1.5 s after the arm began to move. Held means: the arm came to
rest, unpowered, with the cause told; the run is closed and readable; after `reset` everything works
again. Drives that come to rest by themselves when control is gone need real time: `scripts/test
--long` shows that, and `tests/stepped` in stepped time.

| killed | trials | held | s to rest: median | longest | load |
|---|---|---|---|---|---|"""

SUSPENSIONS = """## A process stands still while the arm moves (SIGSTOP), then goes on

Held means: the motion went on, or the arm came to rest and said why; the run is readable; after
`reset` everything works again.

| suspended | trials | held | load | how it ended |
|---|---|---|---|---|"""

JOBS = """## Many jobs

Memory, descriptors and sockets of the daemon and all its processes, files in the data folder (the
last 500 jobs are kept there), after so many jobs; one in twenty is carried out to its end, the
others are cancelled.

| | daemon, MB | all, MB | processes | descriptors | sockets | files |
|---|---|---|---|---|---|---|"""

LAST = """## The second way to stop

`stop` needs the daemon. Where that does not answer, a signal to the control process does the same:
the arm comes to rest along its limits and is held. `pa10d robot stop` asks first, and signals where
the daemon is silent for a second.

```sh
pkill -USR1 -f pa10d.control              # from any terminal
systemctl kill --signal=USR1 pa10d        # as a service: all others ignore it
```

`SIGTERM` to control brings the arm to rest, closes the brakes and takes the power off.

## Budgets

A job may take half of the machine's memory (at least 1, at most 8 GiB; `PA10D_JOB_MEMORY` in MiB
says otherwise) and an hour; what a request waits for, two minutes, in processes of its own. 64 jobs
are taken on at a time, the next one is told to wait (429). A compressed recording may grow
two-hundredfold, a recording at equal steps twentyfold. A run begins only where the disk has room
for its plan.
"""


IN_TABLES = ("kills", "suspensions", "working")  # parts


def page(found: dict[str, Figures]) -> str:
    """found: by ``part.trial``, each with ``what`` and ``load``."""
    lines = [INTRODUCTION, STOPS, *map(_stop_row, _with(found, "stop_ms")), ""]
    if kills := _of(found, "kills"):
        lines += [KILLS, *(_kill_row(n, f) for n, f in kills.items()), "", *_failures(kills)]
    if stood := _of(found, "suspensions"):
        lines += [SUSPENSIONS, *(_stand_row(n, f) for n, f in stood.items()), "", *_failures(stood)]
    if jobs := found.get("working.many_jobs"):
        lines += [JOBS, *(_row(when, *held.values()) for when, held in jobs["held"].items()), ""]
        lines += [f"{jobs['jobs']} jobs in {jobs['seconds']:.0f} s, load {jobs['load']}; "
                  f"told to wait (429): {jobs['told_to_wait']}.", ""]  # fmt: skip
    lines += ["## Everything else", ""]
    lines += [
        f"- **{entry['what']}** (load {entry['load']}): " + "; ".join(_told(entry))
        for name, entry in found.items()
        if "stop_ms" not in entry and name.partition(".")[0] not in IN_TABLES
    ]
    return "\n".join([*lines, "", LAST])


def _of(found: dict[str, Figures], part: str) -> dict[str, Figures]:
    return {k.partition(".")[2]: v for k, v in found.items() if k.startswith(f"{part}.")}


def _with(found: dict[str, Figures], key: str) -> list[Figures]:
    return [entry for entry in found.values() if key in entry]


def _stop_row(entry: Figures) -> str:
    ms = entry["stop_ms"]
    besides = "; ".join(_told({k: v for k, v in entry.items() if k != "stop_ms"}))
    what = entry["what"].removeprefix("stop, ").removeprefix("while ")
    figures = (ms["requests"], *(f"{ms[k]:.0f}" for k in ("median", "p99", "longest")))
    return _row(what, *figures, entry["load"], besides)


def _kill_row(name: str, entry: Figures) -> str:
    rest = (entry.get("median_s_to_rest", "–"), entry.get("longest_s_to_rest", "–"))
    return _row(name.replace("_", " "), entry["trials"], entry["held"], *rest, entry["load"])


def _stand_row(name: str, entry: Figures) -> str:
    ended = "; ".join(f"{n} × {how}" for how, n in entry.get("ended", {}).items())
    return _row(name.replace("_", " "), entry["trials"], entry["held"], entry["load"], ended)


def _row(*cells: Any) -> str:
    return "| " + " | ".join(str(cell).replace("|", "/") for cell in cells) + " |"


def _failures(entries: dict[str, Figures]) -> list[str]:
    said = [f"- did not hold: `{line}`" for e in entries.values() for line in e.get("failures", ())]
    return [*said, ""] if said else []


def _told(entry: Figures) -> Iterator[str]:
    for key, value in entry.items():
        if key not in ("what", "load"):
            yield f"{key.replace('_', ' ')}: {_shown(value)}"


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{k}: {_shown(v)}" if isinstance(v, dict) else f"{k} {_shown(v)}"
                         for k, v in value.items())  # fmt: skip
    if isinstance(value, float):
        return f"{value:.0f}"
    if isinstance(value, list):
        return ", ".join(map(_shown, value))
    return str(value).replace("_", " ")
