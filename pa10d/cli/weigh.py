"""``pa10d weigh``: known weights set the scale of the arm's torques, step by step."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, note, table
from pa10d.cli.commands import Subcommands, WrongUsage, current
from pa10d.cli.daemon_client import daemon_for, progress_line, robot_options
from pa10d.cli.scale import in_words as scale_in_words
from pa10d.cli.weights import body_of
from pa10d.common.errors import UserError
from pa10d.common.jsonable import parsed

if TYPE_CHECKING:
    from pa10d.services.weighing.told import WeighingStatus


def add_commands(commands: Subcommands) -> None:
    """``weigh`` and what it consists of."""
    group = commands.group(
        "weigh", "torque gains of the joints by weights that are hung on the arm"
    )
    guide_ = group.add(
        "guide",
        guide,
        "all of it: record without a weight, say what to hang, record again, say the gains",
        examples=(
            "pa10d weigh guide --weight 3+-0.005,0.05,0,0.1 --weight 5,0.05,0,0.1",
            "pa10d weigh guide --resume weighing",
        ),
    )
    _weights(guide_)
    guide_.add_argument("--resume", metavar="NAME", help="go on with one that was begun")
    guide_.add_argument(
        "--yes", action="store_true",
        help="do not ask before each recording: the weights hang as they are told (a virtual arm "
        "hangs them itself)",
    )  # fmt: skip
    robot_options(guide_)
    begin_ = group.add(
        "begin",
        begin,
        "plan the motion for the weights at hand; nothing moves",
        examples=("pa10d weigh begin --weight 3,0.05,0,0.1 --name monday",),
    )
    _weights(begin_)
    robot_options(begin_)
    record_ = group.add(
        "record",
        record,
        "record the motion with what hangs on the arm now",
        examples=("pa10d weigh record monday", "pa10d weigh record monday --with 1"),
    )
    record_.add_argument("name", metavar="NAME")
    record_.add_argument(
        "--with", type=int, default=0, dest="weight", metavar="N",
        help="the number of the weight that hangs there (default: 0, none)",
    )  # fmt: skip
    robot_options(record_)
    show_ = group.add(
        "show",
        show,
        "gains, what each weight would bring, and what to do next",
        examples=("pa10d weigh show monday",),
    )
    show_.add_argument("name", metavar="NAME")
    apply_ = group.add(
        "apply",
        apply,
        "write the gains into the profile, as a new version of it",
        examples=("pa10d weigh apply monday", "pa10d weigh apply monday --joints 2 3"),
    )
    apply_.add_argument("name", metavar="NAME")
    apply_.add_argument(
        "--joints", type=int, nargs="+", default=[], metavar="J",
        help="these only (default: all that are determined, and not left open by friction)",
    )  # fmt: skip
    undo_ = group.add(
        "undo",
        undo,
        "the profile as it was before",
        examples=("pa10d weigh undo monday",),
    )
    undo_.add_argument("name", metavar="NAME")


def _weights(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--weight", action="append", default=[], metavar="BODY",
        help="MASS,X,Y,Z of a weight at hand (kg, its centre in the last joint's frame, m; each "
        "also VALUE+-ERROR); again for another",
    )  # fmt: skip
    parser.add_argument("--name", help="of the weighing (default: numbered)")


def _require_weights(options: argparse.Namespace) -> None:
    if not options.weight:
        raise WrongUsage("--weight: found none, expected MASS,X,Y,Z of at least one at hand")
    for text in options.weight:
        body_of(text, "--weight")


def begin(options: argparse.Namespace) -> Answer:
    """``weigh begin``."""
    from pa10d.services.weighing.work import begin as begun
    from pa10d.services.weighing.work import status

    _require_weights(options)
    found = status(begun(_data(options), options.profile, options.weight, options.name))
    return Answer(found, in_words(found))


def show(options: argparse.Namespace) -> Answer:
    """``weigh show``."""
    from pa10d.services.weighing.archive import Weighings
    from pa10d.services.weighing.work import status

    found = status(Weighings(options.data).find(options.name))
    return Answer(found, in_words(found))


def record(options: argparse.Namespace) -> Answer:
    """``weigh record``."""
    from pa10d.services.weighing.archive import Weighings
    from pa10d.services.weighing.told import WeighingStatus
    from pa10d.services.weighing.work import refuse_unknown

    state = Weighings(options.data).find(options.name)
    refuse_unknown(state, options.weight)
    current.patient = True  # it may have started a daemon
    with daemon_for(options) as client:
        found = parsed(WeighingStatus, client.weigh(state.id, options.weight, progress_line()))
    return Answer(found, in_words(found))


def guide(options: argparse.Namespace) -> Answer:
    """``weigh guide``."""
    from pa10d.services.weighing.archive import Weighings
    from pa10d.services.weighing.told import WeighingStatus
    from pa10d.services.weighing.work import begin as begun
    from pa10d.services.weighing.work import judge, status

    if options.resume is not None and options.weight:
        raise WrongUsage("--resume: goes on with its own weights; expected no --weight")
    if options.resume is None:
        _require_weights(options)
    state = (
        Weighings(options.data).find(options.resume)
        if options.resume is not None
        else begun(_data(options), options.profile, options.weight, options.name)
    )
    found = judge(_data(options), state.id) if state.pending else status(state)
    note(f"Ctrl-C stops it; 'pa10d weigh guide --resume {state.name}' goes on from there.")
    current.patient = True
    with daemon_for(options) as client:
        while (weight := found.next.weight) is not None:
            note(found.next.says)
            if not options.yes:
                _asked()
            found = parsed(WeighingStatus, client.weigh(state.id, weight, progress_line()))
            note(found.advice or "")
    return Answer(found, in_words(found))


def apply(options: argparse.Namespace) -> Answer:
    """``weigh apply``."""
    from pa10d.client import daemon_serving
    from pa10d.services.weighing.apply import apply_gains
    from pa10d.services.weighing.told import ChangedProfile

    with daemon_serving(options.data, _file(options)) as client:
        if client is None:
            found = apply_gains(_data(options), options.name, options.joints)
        else:
            found = parsed(ChangedProfile, client.apply_weighing(options.name, options.joints))
    written = found.applied.gains if found.applied else {}
    gains = ", ".join(f"joint {j}: {g:g}" for j, g in written.items())
    text = (
        f"{found.file} is version {found.version} now, with torque_gain of {gains}\n"
        f"back: pa10d weigh undo {found.name}"
    )
    return Answer(found, text)


def undo(options: argparse.Namespace) -> Answer:
    """``weigh undo``."""
    from pa10d.client import daemon_serving
    from pa10d.services.weighing.apply import undo_gains
    from pa10d.services.weighing.told import ChangedProfile

    with daemon_serving(options.data, _file(options)) as client:
        if client is None:
            found = undo_gains(_data(options), options.name)
        else:
            found = parsed(ChangedProfile, client.undo_weighing(options.name))
    return Answer(found, f"{found.file} is what it was before")


def _file(options: argparse.Namespace) -> str:
    """The profile that the weighing is of: as ``profile tune`` has it, the daemon that serves it
    changes it, and this process where none does."""
    from pa10d.services.tuning import own_profile
    from pa10d.services.weighing.archive import Weighings

    return str(own_profile(options.data, Weighings(_data(options)).find(options.name).profile))


def in_words(found: WeighingStatus) -> str:
    """How far it is, for the terminal."""
    rows = [
        ["0", "nothing", str(len(found.empty))],
        *([str(w.number), w.says, str(len(w.runs))] for w in found.weights),
    ]
    parts = [
        f"{found.name}: {found.motion.seconds:.0f} s of motion for each recording",
        *found.motion.notes,
        table(["number", "weight", "runs"], rows),
    ]
    if found.joints:
        parts.append(scale_in_words(found.joints, found.prospects, found.advice))
    return "\n".join([*parts, f"next: {found.next.says}"])


def _asked() -> None:
    """Whether the arm is as it was told."""
    if not sys.stdin.isatty():
        raise UserError("weigh guide: nobody to ask on this terminal; expected --yes")
    note("Enter: it is so, and nobody stands within reach. Ctrl-C: not yet.")
    input()


def _data(options: argparse.Namespace) -> str:
    from pa10d.store.location import data_folder

    return str(data_folder(options.data))
