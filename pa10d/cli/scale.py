"""``pa10d scale``: what one newton metre of the sensors is, by a known weight."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, table
from pa10d.cli.commands import Subcommands, WrongUsage, profile_option
from pa10d.cli.weights import body_of

if TYPE_CHECKING:
    from pa10d.services.torque_scale import JointScale, WeightProspect


def add_commands(commands: Subcommands) -> None:
    """``scale``."""
    parser = commands.add(
        "scale",
        scale,
        "absolute torque gain of every joint, from runs with a known weight",
        examples=(
            "pa10d scale --empty e1 e2 --payload 2.0,0,0,0.1 w1 w2 --profile robot.yaml",
            "pa10d scale --empty e1 --payload 3+-0.005,0,0,0.1+-0.002 w1 --at-hand 5,0,0,0.1",
            "pa10d scale --alone --payload 0.49,0,0,-0.1 swing1 swing2 --profile servo.urdf",
        ),
    )
    parser.add_argument("--empty", nargs="+", metavar="RUN", default=[], help="without any weight")
    parser.add_argument(
        "--payload", nargs="+", metavar="BODY RUN", action="append", required=True,
        help="MASS,X,Y,Z (kg, its centre in the last joint's frame, m; each also VALUE+-ERROR) and "
        "the runs with it; again for a second weight",
    )  # fmt: skip
    parser.add_argument(
        "--at-hand", nargs="+", metavar="BODY", default=[],
        help="other weights that could be hung: says what each would bring",
    )  # fmt: skip
    parser.add_argument(
        "--alone", action="store_true",
        help="the weight is all that hangs on the joints (a servo on a bench): no empty run",
    )  # fmt: skip
    profile_option(parser)


def scale(options: argparse.Namespace) -> Answer:
    """``scale``."""
    from pa10d.services.robots import load_robot
    from pa10d.services.scale import torque_scale
    from pa10d.store import RunStore

    _, robot = load_robot(options.profile)
    if options.alone is bool(options.empty):
        raise WrongUsage(
            "scale: expected --empty RUN, recorded without the weight, or --alone where the weight "
            "is all that the joints carry"
        )
    loads = [(body_of(body, "--payload"), runs) for body, *runs in options.payload]
    for body, *runs in options.payload:
        if not runs:
            raise WrongUsage(f"--payload {body}: no run, expected BODY and the runs with it")
    at_hand = [body_of(text, "--at-hand") for text in options.at_hand]
    found = torque_scale(robot, RunStore(options.data), options.empty, loads, at_hand)
    return Answer(found, in_words(found.joints, found.prospects, found.advice))


def in_words(
    gains: Sequence[JointScale], prospects: Sequence[WeightProspect], advice: str | None
) -> str:
    """Gains, weights at hand and advice, for the terminal."""
    head = ["joint", "name", "measured / true torque", "friction leaves", "to mend it"]
    parts = [table(head, [one.row for one in gains])]
    if prospects:
        joints = [f"joint {one.joint}" for one in gains]
        parts.append(table(["would tell", *joints], [one.row for one in prospects]))
    return "\n".join([*parts, *([advice] if advice else [])])
