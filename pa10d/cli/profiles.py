"""``pa10d profile …``: which robots there are, a new one, and how one is tuned."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pa10d.cli import tuning
from pa10d.cli.answer import Answer, note, table
from pa10d.cli.commands import Subcommands, replace_option

if TYPE_CHECKING:
    from pa10d.services.new_profile.answers import Question

OPTIONS = {
    "name": ("NAME", "of the robot (default: the URDF's)"),
    "mounting": ("HOW", "floor, ceiling, wall or R,P,Y: the base's turn, rad (default: floor)"),
    "velocity": ("V", "largest speeds, rad/s (m/s): one, or one per joint with commas"),
    "acceleration": ("A", "largest accelerations, rad/s² (m/s²), likewise"),
    "torque": ("T", "largest torques at the joints, N·m (N), likewise"),
    "tool_mass": ("KG", "of a tool that is always there (default: none)"),
    "tool_com": ("X,Y,Z", "its centre of mass in the last joint's frame, m"),
    "bus": ("CHANNEL", "virtual (the default) or a CAN interface such as can0"),
    "rate": ("HZ", "of the control loop (default: 500, or what the bus leaves room for)"),
}


def add_commands(commands: Subcommands) -> None:
    """The family ``profile``."""
    profiles = commands.group("profile", "robots: a new one from a URDF, and those that there are")
    parser = profiles.add(
        "new",
        new,
        "a commented profile for the robot of a URDF; asks, or --yes",
        examples=(
            "pa10d profile new robot.urdf",
            "pa10d profile new robot.urdf --yes --out arm.yaml --torque 50,50,20,5",
        ),
    )
    parser.add_argument("urdf", type=Path, metavar="ROBOT.urdf")
    parser.add_argument("--out", type=Path, metavar="FILE", help="default: ./NAME.yaml")
    parser.add_argument(
        "--joints", nargs="+", metavar="JOINT", help="names, in order (default: every movable one)"
    )
    for key, (metavar, says) in OPTIONS.items():
        parser.add_argument(f"--{key.replace('_', '-')}", metavar=metavar, help=says)
    parser.add_argument("--yes", action="store_true", help="ask nothing, take the defaults")
    replace_option(parser, "an existing file")
    profiles.add(
        "list",
        list_,
        "the profiles that --profile knows by name",
        examples=("pa10d profile list",),
    )
    tuning.add_to(profiles)


def new(options: argparse.Namespace) -> Answer:
    """``profile new``."""
    from pa10d.services.new_profile import answers_for, facts_of, profile_text, write_profile
    from pa10d.services.new_profile.write import named_from

    facts = facts_of(options.urdf, options.joints)
    robot = facts.robot
    for doubt in facts.doubts:
        note(f"warning: {doubt}")
    given = {key: getattr(options, key) for key in OPTIONS}
    asked = not (options.yes or options.json) and sys.stdin.isatty()
    if asked:
        named = ", ".join(robot.joint_names)
        note(f"{options.urdf}: {robot.n} joints: {named}. Enter takes what stands in brackets.")
    answers = answers_for(facts, robot.name, given, _dialogue(input) if asked else None)
    path = options.out or Path(f"{answers.name}.yaml")
    text = profile_text(facts, answers, named_from(path, options.urdf))
    write_profile(path, text, options.replace)
    assumed = {
        key: [j + 1 for j, flag in enumerate(flags) if flag]
        for key, flags in answers.assumed.items()
        if any(flags)
    }
    for key, joints in assumed.items():
        every = len(joints) == robot.n
        which = "every joint" if every else f"joint {', '.join(map(str, joints))}"
        note(f"assumed: limits.{key} of {which}; see the file")
    document = {
        "file": path.absolute(), "name": answers.name, "joints": list(robot.joint_names),
        "assumed": assumed, "warnings": facts.doubts,
    }  # fmt: skip
    return Answer(document, str(path))


def list_(options: argparse.Namespace) -> Answer:
    """``profile list``."""
    from pa10d.services.robots import shipped_robots

    found = shipped_robots()
    rows = [[one["name"], str(one["joints"]), one["says"]] for one in found]
    return Answer(found, table(["name", "joints", "what it is"], rows))


def _dialogue(read: Callable[[str], str]) -> Callable[[Question], Any]:
    """Ask until an answer can be used; an empty one takes the default."""

    def ask(question: Question) -> Any:
        while True:
            try:
                text = read(f"{question.text} [{question.shown(question.default)}]: ").strip()
            except EOFError:
                return question.default
            if not text:
                return question.default
            try:
                return question.parse(text)
            except ValueError as error:
                note(f"{text!r}: expected {error}")

    return ask
