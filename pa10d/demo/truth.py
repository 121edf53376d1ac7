"""The answer of the story against what the simulator had hidden."""

from __future__ import annotations

from collections.abc import Sequence

from pa10d.common.words import listed
from pa10d.demo.hidden import Hidden
from pa10d.effects import all_effects
from pa10d.investigation.results import NamedEffect, Structured
from pa10d.investigation.words import named


def judged(
    hidden: Hidden, findings: Sequence[NamedEffect], unexplained: Sequence[Structured]
) -> bool | None:
    """Is the first finding what was hidden, joints included? None: nobody knows."""
    if hidden.foreign:
        return None
    if hidden.name is None:
        return not findings and not unexplained
    if hidden.name not in all_effects():
        return not findings and bool({s.joint for s in unexplained} & set(hidden.joints))
    if not findings:
        return False
    first = findings[0]
    return first.effect == hidden.name and sorted(first.joints) == sorted(hidden.joints)


def _same(one: NamedEffect, other: NamedEffect) -> bool:
    return one.effect == other.effect and sorted(one.joints) == sorted(other.joints)


def verdict_on(
    hidden: Hidden, findings: Sequence[NamedEffect], unexplained: Sequence[Structured]
) -> str:
    """The same in a sentence."""
    right = judged(hidden, findings, unexplained)
    if right is None:
        return "What the plant hides is known to whoever wrote it."
    if right and hidden.name is None:
        return "The diagnosis was right to find nothing."
    if right and hidden.name not in all_effects():
        return "No effect of the library is like that; the diagnosis said so, and named the joint."
    if right:
        more = sum(not _same(finding, findings[0]) for finding in findings)
        also = f" (It named {more} more, which are not there.)" if more else ""
        return f"The diagnosis was right.{also}"
    words = listed([named(finding) for finding in findings]) or "nothing that it has a name for"
    if any(finding.effect == hidden.name for finding in findings[1:]):
        return f"The diagnosis was half right: it named {words}, the true one not first."
    text = f"The diagnosis was wrong: it named {words}."
    if any(c.effect == hidden.name for f in findings for c in f.confounded_with):
        text += " It did say that this data cannot tell the two apart."
    return text
