"""``pa10d track``: what a model, or an effect in it, is worth to a controller."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import Any

from pa10d.cli.answer import Answer, note, table
from pa10d.cli.commands import Subcommands, WrongUsage, file_option, replace_option
from pa10d.cli.daemon_client import daemon_for, read_plan, robot_options
from pa10d.cli.progress import progress_line
from pa10d.cli.story import end_as_after_interrupt, seed_number, study_folder, tell
from pa10d.common.jsonable import JsonObject

WORDS = {"pid": "PID", "feed_forward": "PID + feed-forward", "computed_torque": "computed torque"}


def add_commands(commands: Subcommands) -> None:
    """``track``."""
    parser = commands.add(
        "track",
        track,
        "one motion under PID, feed-forward and computed torque: what a model is worth",
        patient=True,
        examples=(
            "pa10d track m0 m1",
            "pa10d track m0 m1 --set period=20 --name slow --out slow.csv",
            "pa10d track --hide stribeck:4 --seed 3",
        ),
    )
    parser.add_argument(
        "models", metavar="MODEL", nargs="*",
        help="of this data, from the textbook's to the best; the arm moves under each",
    )  # fmt: skip
    parser.add_argument(
        "--hide", metavar="EFFECT[:JOINT]",
        help="instead of MODELs: a virtual arm that hides this is investigated before",
    )  # fmt: skip
    parser.add_argument(
        "--seed", type=seed_number, default=1, metavar="N", help="of that arm (default: 1)"
    )
    parser.add_argument(
        "--kind",
        dest="motion",
        metavar="KIND",
        default="tracking",
        help="of the motion (default: tracking, sines of all joints)",
    )
    parser.add_argument(
        "--set", dest="settings", metavar="KEY=VALUE", nargs="+", action="extend", default=[],
        help="parameters of the kind, such as period=20",
    )  # fmt: skip
    parser.add_argument("--name", metavar="RUN", help="of the runs, which get a number each")
    file_option(parser, "out", "write the table as CSV, too")
    replace_option(parser, "the runs of this name")
    robot_options(parser)


def track(options: argparse.Namespace) -> Answer:
    """``track``."""
    from pa10d.services.documents import Track
    from pa10d.services.models import write_file
    from pa10d.services.tracking import as_csv

    if bool(options.models) == (options.hide is not None):
        raise WrongUsage(
            "track: expected MODELs of this data, or --hide EFFECT:JOINT for a virtual arm"
        )
    motion = read_plan(options.motion, None, options.settings)
    found = _of_models(options, motion) if options.models else _of_hidden(options, motion)
    if options.out is not None:
        write_file(options.out.absolute(), as_csv(Track.model_validate(found)))
        found["file"] = str(options.out.absolute())
    return Answer(found, in_words(found))


def _of_models(options: argparse.Namespace, motion: JsonObject) -> JsonObject:
    def before() -> None:
        from pa10d.services.experiments import refuse_wrong_request
        from pa10d.services.library import open_library
        from pa10d.services.robots import load_robot

        refuse_wrong_request(load_robot(options.profile)[1], motion["kind"], motion["parameters"])
        for model in options.models:
            open_library(options.data).models.find(model)

    with daemon_for(options, before) as client:
        return client.track(
            options.models, motion["kind"], motion["parameters"], progress_line(),
            name=options.name, replace=options.replace,
        )  # fmt: skip


def _of_hidden(options: argparse.Namespace, motion: JsonObject) -> JsonObject:
    from pa10d.demo.bench import Bench
    from pa10d.demo.hidden import hide
    from pa10d.demo.worth import refuse_what_comes_later, worth
    from pa10d.profile import load_profile
    from pa10d.services.experiments import refuse_impossible_motion
    from pa10d.services.robots import load_robot

    profile = load_profile(options.profile)
    hidden = hide(options.hide, options.seed, profile)
    refuse_what_comes_later(options.hide, hidden)
    robot = load_robot(options.profile)[1]
    refuse_impossible_motion(robot, motion["kind"], motion["parameters"])
    bench = Bench(profile, hidden, options.seed)
    end_as_after_interrupt()
    tell(f"1. A simulated {profile.name} and its daemon start (seed {options.seed}).")
    with study_folder(options.data) as data, bench.running(data):
        found = worth(bench, hidden, motion, tell, progress_line())
    tell(f"What was hidden: {hidden.in_words()}.")
    if not found["worth"]:
        note("nothing was found: there is one model, and no improved one to compare it with")
    return found


def in_words(found: Mapping[str, Any]) -> str:
    """Tracking errors per joint and law in thousandths, and what the last model is worth."""
    rows = [
        [
            WORDS[law["controller"]] + (f", {law['model']}" if law["model"] else ""),
            *(f"{1e3 * rms:.3g} ({1e3 * most:.3g})" for rms, most in
              zip(law["rms"], law["max"], strict=True)),
        ]
        for law in found["laws"]
    ]  # fmt: skip
    for one in found["worth"]:
        shares = ("–" if v is None else f"{v:.2f}" for v in one["rms"])
        rows.append([f"{WORDS[one['controller']]}: {one['to']} / {one['from']}", *shares])
    head = ["", *(f"{j + 1} {name}" for j, name in enumerate(found["joints"]))]
    unit = "Tracking error, RMS (largest), mrad (mm where a joint slides):"
    lines = [
        f"{WORDS[one['controller']]}: with {one['to']} instead of {one['from']} joint "
        f"{one['joint']} is off by {1e3 * one['after']:.3g} instead of "
        f"{1e3 * one['before']:.3g} mrad."
        for one in found["worth"]
    ]
    return "\n".join([unit, table(head, rows), *lines])
