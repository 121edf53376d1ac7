"""Does each drive answer for its own joint?

A drive is asked where it stands by its node id (SDO); what comes in every cycle is known by its
COB-ID alone. Where those differ, and what comes is where another drive stands, two drives answer
for each other: whoever powers that arm moves one joint and watches the other.
"""

from __future__ import annotations

from collections.abc import Sequence

from backends.faults import refusal

NEAR = 1e-3  # rad, or m: a joint in its brake moves less


def require_own(
    nodes: Sequence[int], told: Sequence[int | None], heard: Sequence[int], near: Sequence[float]
) -> None:
    """BackendFault where a drive answers for another. told, heard: counts by SDO, None where it
    tells none, and by PDO; near: counts that count as the same."""
    causes = {}
    for axis, (own, seen) in enumerate(zip(told, heard, strict=True)):
        if own is None or abs(seen - own) <= near[axis]:
            continue
        others = [
            k
            for k, other in enumerate(told)
            if k != axis and other is not None and abs(seen - other) <= near[k]
        ]
        if len(others) == 1:
            causes[axis] = (
                f"node {nodes[axis]} stands at {own} counts by SDO, and its TPDO brings {seen}, "
                f"where node {nodes[others[0]]} stands: the drives answer for each other; give "
                "their TPDOs (0x1800:1) the COB-IDs of their own nodes, 0x180 + node"
            )
    if causes:
        raise refusal("setup", causes)
