"""Counters that wrap round: what a drive sent with a sign, read without it; angles that begin anew
every turn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pa10d.checks.finding import CheckFinding, Mend, joint_label
from pa10d.measurement.counters import WORDS, Wrap, wrap_of
from pa10d.measurement.recording import Recording

Wraps = Mapping[str, Wrap]
"""Field, such as q1 -> how its numbers begin anew."""


def wraps_in(recording: Recording) -> dict[str, Wrap]:
    """As far as equal steps still tell it."""
    blocks = {"q": recording.q, "tau": recording.tau, "dq": recording.dq}
    found = {
        f"{field}{j + 1}": wrap_of(block[:, j], position=field == "q")
        for field, block in blocks.items()
        if block is not None
        for j in range(recording.joints)
    }
    return {field: wrap for field, wrap in found.items() if wrap is not None}


def check_counters(wraps: Wraps, names: tuple[str, ...] | None) -> Iterator[CheckFinding]:
    """What the numbers of drives and encoders look like when they wrap."""
    for field, wrap in wraps.items():
        kind = field.rstrip("0123456789")
        j = int(field[len(kind) :]) - 1
        label = joint_label(j, names)
        if wrap.sign_bits:
            yield _lost_sign(wrap, field, kind, label, j)
        elif kind == "q":  # torques and speeds that jump do not run on behind it
            yield _ran_over(wrap, field, label, j)


def _lost_sign(wrap: Wrap, field: str, kind: str, label: str, j: int) -> CheckFinding:
    bits = wrap.sign_bits
    word, signed = WORDS[bits], Mend(field, f"i{bits}")
    seen = f"jumps between 0 and {word:.0f}"
    if not wrap.told:
        seen = f"stays between {word / 2:.0f} and {word:.0f}"
    return CheckFinding(
        "error",
        "wrapped",
        f"{label}: {kind} {seen}: numbers with a sign, read without it ({word - 1:.0f} for −1)",
        f"--map {signed.option}, with the unit's factor behind it, such as [i{bits}*0.001]",
        j + 1,
        (signed,),
    )


def _ran_over(wrap: Wrap, field: str, label: str, j: int) -> CheckFinding:
    mend = Mend(field, wrap.written, complete=wrap.told)
    about = "" if wrap.told else "about "
    more = "" if wrap.told else " with the counts after which it begins anew"
    factor = "" if "*" in wrap.written else f", and what it counts: [{wrap.written}*rev/COUNTS]"
    return CheckFinding(
        "error",
        "wrapped",
        f"{label}: q begins anew after {about}{wrap.period:.6g} while the joint moves on",
        f"--map {mend.option}{more or factor}",
        j + 1,
        (mend,),
    )
