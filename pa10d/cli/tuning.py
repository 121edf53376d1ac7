"""``pa10d profile show``, ``tune``, ``undo``, ``versions``: gains, limits and surroundings."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from pa10d.cli.answer import Answer, note, table
from pa10d.cli.commands import Subcommands, WrongUsage, profile_option
from pa10d.common.jsonable import JsonObject, parsed

if TYPE_CHECKING:
    from pa10d.services.tuning import ProfileDifference, ProfileTuning, ProfileVersion

T = TypeVar("T")


def add_to(profiles: Subcommands) -> None:
    """To the family ``profile``."""
    showing = profiles.add(
        "show",
        show,
        "gains, limits and surroundings in force, and where each comes from",
        examples=("pa10d profile show", "pa10d profile show --profile arm.yaml"),
    )
    tuning = profiles.add(
        "tune",
        tune,
        "change gains, limits or surroundings: what that does is shown, then written",
        examples=(
            "pa10d profile tune control.bandwidth_hz=3 --check",
            "pa10d profile tune limits.velocity.2=0.8 limits.torque.2=90 --profile arm.yaml",
            "pa10d profile tune control.gains.kp=null",
        ),
    )
    tuning.add_argument(
        "settings", metavar="KEY[.JOINT]=VALUE", nargs="+",
        help="such as limits.velocity.2=0.8; null: what holds where the profile says nothing",
    )  # fmt: skip
    undoing = profiles.add(
        "undo",
        undo,
        "take the last change back that was made so",
        examples=("pa10d profile undo --check", "pa10d profile undo"),
    )
    changed = profiles.add(
        "versions",
        versions,
        "what was changed so, newest first",
        examples=("pa10d profile versions",),
    )
    for parser in (showing, tuning, undoing, changed):
        profile_option(parser)
    for parser in (tuning, undoing):
        parser.add_argument("--check", action="store_true", help="say what it does, write nothing")
        parser.add_argument(
            "--confirm", action="store_true", help="even where that lets the arm do more"
        )


def show(options: argparse.Namespace) -> Answer:
    """``profile show``."""
    with _tuning(options) as about:
        found = about.show()
    joints = [f"{k}" for k in range(1, len(found.joints) + 1)]
    rows = [
        [one.key, one.units[0], one.source,
         *(map(_short, one.in_force) if one.per_joint else [_short(one.in_force)])]
        for one in found.values
    ]  # fmt: skip
    width = 3 + len(joints)
    rows = [row + [""] * (width - len(row)) for row in rows]
    head = f"{found.file}, version {found.version}"
    return Answer(found, "\n".join([head, table(["key", "unit", "from", *joints], rows)]))


def tune(options: argparse.Namespace) -> Answer:
    """``profile tune``: by the daemon that serves this profile, where there is one."""
    changes = _changes(options.settings)
    with _tuning(options) as about:
        found = about.check(changes)
        if options.check or not _agreed(found, options):
            return _difference(found, options.check)
        return _difference(about.tune(changes, options.confirm), True)


def undo(options: argparse.Namespace) -> Answer:
    """``profile undo``."""
    with _tuning(options) as about:
        found = about.undo(check=True)
        if options.check or not _agreed(found, options):
            return _difference(found, options.check)
        return _difference(about.undo(confirmed=options.confirm), True)


def versions(options: argparse.Namespace) -> Answer:
    """``profile versions``."""
    with _tuning(options) as about:
        found = about.versions()
    lines = [
        f"{one.version}  {one.when}{'  undone' if one.undone else ''}  " + "; ".join(one.changes)
        for one in found
    ]
    return Answer(found, "\n".join(lines) or "none: nothing was tuned or undone yet")


@dataclass(frozen=True)
class _Tuner:
    """Who answers: the daemon that serves the profile, and goes on with it, else this process."""

    show: Callable[[], ProfileTuning]
    check: Callable[..., ProfileDifference]
    tune: Callable[..., ProfileDifference]
    undo: Callable[..., ProfileDifference]
    versions: Callable[[], list[ProfileVersion]]


@contextlib.contextmanager
def _tuning(options: argparse.Namespace) -> Iterator[_Tuner]:
    from pa10d.client import daemon_serving
    from pa10d.services import tuning as here

    own = here.own_profile(options.data, options.profile)
    with daemon_serving(options.data, own) as client:
        if client is not None:
            yield _Tuner(
                _typed(here.ProfileTuning, client.tuning),
                _typed(here.ProfileDifference, client.check_tuning),
                _typed(here.ProfileDifference, client.tune),
                _typed(here.ProfileDifference, client.undo_tuning),
                _typed(list[here.ProfileVersion], client.tuning_versions),
            )
            return
        of = (options.data, options.profile)
        yield _Tuner(
            partial(here.show, *of),
            partial(here.propose, *of),
            partial(here.write, *of),
            partial(here.undo, *of),
            partial(here.versions, *of),
        )


def _typed(kind: type[T], ask: Callable[..., Any]) -> Callable[..., T]:
    """The daemon's document as what the service returns."""
    return lambda *given, **named: parsed(kind, ask(*given, **named))


def _changes(settings: list[str]) -> JsonObject:
    """``limits.velocity.2=0.8`` and the like, by keys."""
    import yaml

    changes: JsonObject = {}
    for setting in settings:
        name, equals, text = setting.partition("=")
        if not equals:
            raise WrongUsage(f"{setting}: expected KEY=VALUE")
        try:
            value = yaml.safe_load(text)
        except yaml.YAMLError as error:
            raise WrongUsage(f"{setting}: found {text!r}, expected a number or a list") from error
        key, _, joint = name.rpartition(".")
        if not joint.isdecimal():
            changes[name] = value
            continue
        before = changes.setdefault(key, {})
        if not isinstance(before, dict):
            raise WrongUsage(f"{setting}: {key} is given as a whole, too; expected one of both")
        before[joint] = value
    return changes


def _agreed(found: ProfileDifference, options: argparse.Namespace) -> bool:
    return options.confirm or not found.confirm


def _difference(found: ProfileDifference, fine: bool) -> Answer:
    """fine: it was not refused for want of a confirmation."""
    lines = [one.sentence + ("" if one.asked else "  (follows)") for one in found.diff]
    for sentence in found.confirm:
        note(f"to be confirmed: {sentence}")
    if not fine:
        note("nothing is written; --confirm writes it")
    for sentence in found.effect:
        note(sentence)
    done = "written" if found.written else "would be"
    return Answer(
        found, "\n".join([*lines, f"{done} version {found.version} of {found.file}"]),
        status=0 if fine else 1,
    )  # fmt: skip


def _short(value: Any) -> str:
    if isinstance(value, list):
        return " ".join(map(_short, value)) if value and not isinstance(value[0], dict) else (
            f"{len(value)} boxes" if value else "none"
        )  # fmt: skip
    return "–" if value is None else f"{value:.5g}" if isinstance(value, int | float) else value
