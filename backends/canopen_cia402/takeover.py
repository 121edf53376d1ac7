"""A drive comes with a past: what we own is made nothing, what gives numbers a meaning has to
agree with the profile. Only objects that the drive has; what it does not tell is told as a lack.
"""

from __future__ import annotations

from fractions import Fraction
from math import isclose

from backends import vendors
from backends.canopen_cia402.objects import lack
from backends.canopen_cia402.remote import Remote, SetupError
from pa10d.profile import Drive

OFFSETS = {
    0x60B0: ("Position offset", "it would be added to every position demand"),
    0x60B1: ("Velocity offset", "it would be added to every velocity demand"),
    0x60B2: ("Torque offset", "it would be added to every torque"),
}
FIXED = {
    0x607E: "Polarity",
    **{index: name for index, (name, _) in OFFSETS.items()},
    0x6076: "Motor rated torque",
    0x608F: "Position encoder resolution",
    0x6091: "Gear ratio",
    0x6092: "Feed",
    0x1400: "RPDO 1",
    0x1600: "Mapping of RPDO 1",
    0x1800: "TPDO 1",
    0x1A00: "Mapping of TPDO 1",
    0x6060: "Modes of operation",
}
MOST_SUBS = 8  # of a mapping
SUBS = {0x608F: (1, 2), 0x6091: (1, 2), 0x6092: (1, 2), 0x1400: (1, 2), 0x1800: (1, 2),
        0x1600: range(9), 0x1A00: range(9)}  # fmt: skip
RATED_TORQUE_TOLERANCE = 0.02
RATIO_TOLERANCE = 1e-4  # of a gear that both sides write as a ratio of small numbers
POLARITY_BITS = {0x80: "position", 0x40: "velocity", 0x20: "torque"}
ONE_SIDED = {0x60E0: "Positive torque limit value", 0x60E1: "Negative torque limit value"}
TORQUE_LIMITS = {0x6072: "Max torque", **ONE_SIDED}
OFF, NOT_USED = 1 << 31, 1 << 30  # bits of a COB-ID
SYNC_ID, SYNC_BITS, PRODUCES = 0x80, 0x7FFFFFFF, 1 << 30  # bit 31 means nothing


def clear_offsets(remote: Remote) -> list[str]:
    """What an earlier master left behind is zero now; reasons where it is not."""
    reasons = []
    for index, (name, meaning) in OFFSETS.items():
        if (problem := remote.ensure(index, 0)) is not None:
            reasons.append(f"{name} (0x{index:04X}): expected 0, {problem}: {meaning}")
    return reasons


def own_sync(remote: Remote) -> list[str]:
    """The drive obeys our SYNC, as it is, and produces none."""
    reasons = []
    found = remote.read(0x1005) or SYNC_ID
    if found & PRODUCES:  # its identifier cannot be changed before that has ended
        remote.write(0x1005, found & ~PRODUCES)
    if found & SYNC_BITS != SYNC_ID and (problem := remote.ensure(0x1005, SYNC_ID)) is not None:
        reasons.append(f"COB-ID SYNC (0x1005): expected 0x80, {problem}: ours is not heard")
    if remote.read(0x1019):  # cannot be changed while a period is set; ours is written later
        remote.ensure(0x1006, 0)
    if (problem := remote.ensure(0x1019, 0)) is not None:
        reasons.append(f"SYNC counter (0x1019): expected 0, {problem}: our SYNC has no counter")
    if (problem := remote.ensure(0x1007, 0)) is not None:
        reasons.append(
            f"Synchronous window length (0x1007): expected 0, {problem}: commands that come later "
            "after SYNC would be thrown away"
        )
    return reasons


def hear_emergencies(remote: Remote) -> list[str]:
    """The drive tells its errors where we listen; else what that means."""
    found, expected = remote.read(0x1014), 0x80 + remote.node.id
    if found is None or found & ~NOT_USED in (0, expected):  # 0: as the drive has it by itself
        return []
    remote.write(0x1014, found | OFF)  # its identifier cannot be changed before that
    if (problem := remote.ensure(0x1014, expected)) is None:
        return []
    return [
        f"COB-ID EMCY (0x1014): expected 0x{expected:X}, {problem}: its emergencies are not heard, "
        "a fault shows in the statusword alone"
    ]


def let_through(remote: Remote, per_mille: int, rated: float) -> list[str]:
    """No older limit keeps the drive from the torque that it may be asked for, ``per_mille`` of
    the ``rated`` one, N·m at the joint; else reasons: a joint would sink that shall be held."""
    reasons = []
    for index in ONE_SIDED:
        if remote.read(index) not in (None, per_mille):
            remote.write(index, per_mille)
    for index, name in TORQUE_LIMITS.items():
        found = remote.read(index)
        if found is not None and found < per_mille:
            reasons.append(
                f"{name} (0x{index:04X}): the drive keeps {found} ‰ of its rated torque, "
                f"limits.torque asks for {per_mille}: expected at most {found * rated / 1000:.4g} "
                "N·m in limits.torque, or a drive that gives more"
            )
    return reasons


def contradictions(remote: Remote, drive: Drive, ends: tuple[int, int]) -> list[str]:
    """Where drive and profile give the same number different meanings. ends: counts between which
    the joint moves."""
    return [
        *_polarity(remote),
        *_counts(remote, drive),
        *_range(remote, ends),
        *_rated_torque(remote, drive),
    ]


def fixed_entries(remote: Remote, shows_mode: bool) -> dict[tuple[int, int], int]:
    """What gives the drive's numbers their meaning and their way, as it is now that the drive is
    set up; nobody else may change it. The mode itself, where the drive does not show it."""
    found: dict[tuple[int, int], int] = {}
    for index in FIXED:
        if index == 0x6060 and shows_mode:
            continue
        most = MOST_SUBS
        for sub in SUBS.get(index, (0,)):
            if sub > most:
                break
            try:
                value = remote.read(index, sub)
            except SetupError:  # a drive that does not tell
                continue
            if value is None:
                continue
            if sub == 0 and index in SUBS:
                most = value
            found[index, sub] = value
    return found


def untold(remote: Remote) -> list[str]:
    """What could not be compared."""
    silent = []
    if not remote.read(0x6076):
        silent.append(lack(0x6076))
    if _told(remote, 0x6092) is None and _told(remote, 0x608F) is None:
        silent.append(lack(0x608F))
    return silent


def _polarity(remote: Remote) -> list[str]:
    found = remote.read(0x607E) or 0
    if not found:
        return []
    turned = ", ".join(name for bit, name in POLARITY_BITS.items() if found & bit) or "something"
    return [
        f"Polarity (0x607E): found 0x{found:02X}, the drive turns {turned} round by itself; "
        "expected 0: the profile's sign is the one place for that"
    ]


def _counts(remote: Remote, drive: Drive) -> list[str]:
    """Position units to one revolution of the joint, as CiA 402's chain of factors has them.

    Either the drive knows the gear, then its shaft is the joint, or it does not (1:1), then its
    shaft is the motor's. Without a feed (0x6092) the unit is the increment of the encoder, with a
    known gear some makers' are seen through the gear.
    """
    gear = _ratio(remote, 0x6091)
    knows_gear = gear is not None and gear != 1
    if knows_gear and gear is not None and not _same(float(gear), drive.gear_ratio):
        return [
            f"Gear ratio (0x6091): found {_shown(gear)}, profile gear_ratio has "
            f"{drive.gear_ratio:g}: expected the same, or 1:1 where the drive shall not know it"
        ]
    feed, encoder = _told(remote, 0x6092), _told(remote, 0x608F)
    name, per_turn = ("Feed (0x6092)", feed) if feed else ("Encoder resolution (0x608F)", encoder)
    if per_turn is None:
        return []
    through_gear = float(per_turn) * drive.gear_ratio
    possible = [through_gear] if not knows_gear else [float(per_turn)]
    if knows_gear and not feed:
        possible.append(through_gear)
    if any(_same(counts, drive.counts_per_rev) for counts in possible):
        return []
    expected = " or ".join(f"{counts:g}" for counts in possible)
    return [
        f"{name}: found {_shown(per_turn)} to a turn, with a gear of {drive.gear_ratio:g} that is "
        f"{expected} to one of the joint, profile counts_per_rev has {drive.counts_per_rev:g}"
    ]


def _range(remote: Remote, ends: tuple[int, int]) -> list[str]:
    """A position that runs over within the joint's limits would look like a jump."""
    try:
        low, high = remote.read(0x607B, 1), remote.read(0x607B, 2)
    except SetupError:  # a drive that does not tell
        return []
    if low is None or high is None or low >= high:  # both 0: there is no range
        return []
    if low <= ends[0] and ends[1] <= high:
        return []
    return [
        f"Position range limit (0x607B): found {low} … {high}, the joint moves from {ends[0]} to "
        f"{ends[1]}: its position would run over on the way; expected 0 and 0, or a wider range"
    ]


def _rated_torque(remote: Remote, drive: Drive) -> list[str]:
    rated = remote.read(0x6076)
    if not rated:
        return []
    unit = vendors.rated_torque_unit(remote.read(0x1018, 1) or 0)
    found = rated * unit
    half = 0.5 * unit * (1.0 + 1e-9)  # the drive tells whole units, of a small motor few
    apart = max(half, RATED_TORQUE_TOLERANCE * found)
    if isclose(found, drive.rated_torque, rel_tol=0.0, abs_tol=apart):
        return []
    return [
        f"Motor rated torque (0x6076): found {found:g} N·m, profile has {drive.rated_torque:g}: "
        "every torque would be wrong by that factor"
    ]


def _ratio(remote: Remote, index: int) -> Fraction | None:
    """The first number to the second; None where the drive does not say."""
    above, below = remote.read(index, 1), remote.read(index, 2)
    return Fraction(above, below) if above and below else None


def _told(remote: Remote, index: int) -> Fraction | None:
    """As above, and a single count to a turn is what an EDS has that nobody filled in."""
    ratio = _ratio(remote, index)
    return None if ratio is None or ratio <= 1 else ratio


def _same(a: float, b: float) -> bool:
    return isclose(a, b, rel_tol=RATIO_TOLERANCE)


def _shown(ratio: Fraction) -> str:
    return f"{ratio.numerator}:{ratio.denominator}"
