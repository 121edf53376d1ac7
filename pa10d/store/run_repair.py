"""A run whose recorder was killed: its bag gets its end, its description the truth."""

from __future__ import annotations

from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.store.bag_metadata import write_bag_metadata
from pa10d.store.bag_repair import finish_bag
from pa10d.store.channels import STATES
from pa10d.store.room import give_back
from pa10d.store.run_info import BAG, RunInfo

ENDINGS = ("success", "stopped", "aborted", "failed")


def repair_run(folder: Path, info: RunInfo) -> RunInfo:
    """Finish the bag in ``folder``, whose writer is gone, and say what became of the run."""
    give_back(folder)
    try:
        result = finish_bag(folder / BAG)
    except UserError as error:
        reason = f"the recorder ended before the first sample ({str(error).splitlines()[0]})"
        info = info.but(status="failed", reason=reason)
        info.save(folder)
        return info
    index = result.index
    write_bag_metadata(folder, BAG, index)
    numbers = [k for k, (topic, _) in index.topics.items() if topic == STATES]
    count = sum(index.messages[k] for k in numbers)
    start = index.start or 0
    duration = max(0, index.end - start) / 1e9
    status, reason = result.end.get("status", ""), result.end.get("reason", "")
    if status not in ENDINGS:
        kept = f"{duration:.1f} s were kept"
        status, reason = "failed", f"the recorder ended without closing the run; {kept}"
    info = info.but(
        status=status,
        reason=reason,
        repaired=True,
        samples=count,
        duration=duration,
        rate=(count - 1) * 1e9 / (index.end - start) if duration > 0 else 0.0,
    )
    info.save(folder)
    return info
