"""``pa10d serve``, ``sim``, ``experiment``, ``controller``, ``check``: the robot."""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, note
from pa10d.cli.commands import Subcommands, positive, replace_option, whole_number
from pa10d.cli.daemon_client import robot_options
from pa10d.cli.progress import told_if_slow
from pa10d.common.loading import loading
from pa10d.control.laws import LAWS

if TYPE_CHECKING:
    from pa10d.common.jsonable import JsonObject
    from pa10d.daemon.night import Secret
    from pa10d.dynamics import Robot
    from pa10d.profile import Profile

PORT = 8010
STARTS = "pa10d starts; what is compiled the first time takes up to two minutes on a slow machine"
OF_ANOTHER = (
    "these data are of another virtual arm so far ({0.profile}, --hide {0.hide} --seed {0.seed}, "
    "day {0.day}): recordings of two arms make a model of none; --data FOLDER keeps them apart"
)


def add_commands(commands: Subcommands) -> None:
    """The family around the daemon."""
    serving = commands.add(
        "serve",
        serve,
        "the daemon with HTTP API and web page",
        patient=True,
        examples=(
            "pa10d serve",
            "pa10d serve --profile arm.yaml --port 0",
            "pa10d serve --hide any",
        ),
    )
    serving.add_argument(
        "--port", type=whole_number(0, 65535), default=PORT,
        help=f"0: a free one (default: {PORT})",
    )  # fmt: skip
    serving.add_argument("--host", default="127.0.0.1", help="address to listen on")
    serving.add_argument(
        "--name", dest="names", nargs="+", action="extend", default=[], metavar="HOST",
        help="further names of this machine that a browser may use",
    )  # fmt: skip
    serving.add_argument(
        "--token-file", type=Path, metavar="FILE",
        help='{"look": "…", "command": "…", "admin": "…"} or one token (also: PA10D_TOKEN)',
    )  # fmt: skip
    serving.add_argument(
        "--no-sim", action="store_true", help="do not start the virtual arm of the profile"
    )
    serving.add_argument(
        "--attached", action="store_true", help="end when standard input ends: with who started it"
    )
    serving.add_argument(
        "--hide", metavar="EFFECT[:JOINT]",
        help="let the virtual arm hide an effect, to be found out: 'any' draws one at random",
    )  # fmt: skip
    serving.add_argument("--seed", type=int, help="of what is hidden: same seed, same arm")
    robot_options(serving)
    experimenting = commands.add(
        "experiment",
        experiment,
        "run one experiment → run ids",
        patient=True,
        examples=(
            "pa10d experiment excitation --name train",
            "pa10d experiment tracking --set period=4 joints=[1,2] --name fast",
            "pa10d experiment --plan settle.yaml",
            "pa10d experiment load_sweep --to motion.csv",
        ),
    )
    experimenting.add_argument("kind", metavar="KIND", nargs="?", help="such as tracking")
    experimenting.add_argument(
        "--plan", type=Path, metavar="FILE", help="{kind, parameters} as next_experiment gives it"
    )
    experimenting.add_argument(
        "--set", dest="settings", metavar="KEY=VALUE", nargs="+", action="extend", default=[],
        help="parameters of the kind, such as period=4 joints=[1,2]",
    )  # fmt: skip
    experimenting.add_argument("--name", metavar="RUN", help="of the run (default: the kind)")
    experimenting.add_argument("--tag", dest="tags", nargs="+", action="extend", default=[])
    experimenting.add_argument("--controller", choices=LAWS)
    experimenting.add_argument("--model", help="for the laws with a model")
    experimenting.add_argument("--check", action="store_true", help="the pre-check only")
    experimenting.add_argument(
        "--to", type=Path, metavar="FILE",
        help="write the motion as CSV (time, q1 …) for an arm that another program moves, and run "
        "nothing",
    )  # fmt: skip
    experimenting.add_argument(
        "--recover", action="store_true",
        help="bring an arm that stands outside its position limits back inside first, slowly",
    )  # fmt: skip
    replace_option(experimenting, "the run of this name")
    robot_options(experimenting)
    controlling = commands.add(
        "controller",
        controller,
        "which control law holds and moves the arm from now on",
        examples=(
            "pa10d controller",
            "pa10d controller computed_torque --model m1",
        ),
    )
    controlling.add_argument("law", nargs="?", choices=LAWS, help="absent: say which it is")
    controlling.add_argument(
        "--model", help="for the laws with a model: name, id or the start of one"
    )
    checking = commands.add(
        "check",
        check,
        "go or no-go before power",
        patient=True,
        examples=(
            "pa10d check --profile pa10-7c",
            "pa10d check --seconds 10",
        ),
    )
    checking.add_argument("--seconds", type=positive, default=2.0, help="for each timing test")
    robot_options(checking)
    simulating = commands.add(
        "sim",
        sim,
        "the virtual arm alone, in its own process",
        patient=True,
        examples=(
            "pa10d sim",
            "pa10d sim --profile arm.yaml",
        ),
    )
    robot_options(simulating)


def serve(options: argparse.Namespace) -> Answer:
    """``serve``: until interrupted."""
    ready = told_if_slow(STARTS)
    with loading():
        from backends.arm_lock import is_simulated
        from pa10d.api.access import tokens_from
        from pa10d.api.server import Settings
        from pa10d.api.server import serve as run
        from pa10d.daemon.timekeeping import kept_time, slower
        from pa10d.store.location import data_folder

    tokens = {}
    if options.token_file is not None:
        text = options.token_file.read_text("utf-8", "replace")
        tokens = tokens_from(text, str(options.token_file))
    elif one := os.environ.get("PA10D_TOKEN"):
        tokens = tokens_from(one, "PA10D_TOKEN")
    profile, robot = _as_tuned_here(options)
    settings = Settings(
        data=data_folder(options.data),
        host=options.host,
        port=options.port,
        tokens=tokens,
        names=tuple(options.names),
        simulator=not options.no_sim,
        as_json=options.json,
        attached=options.attached,
        ready=ready,
    )
    profile = _on_bus(profile, options)
    if options.clock or options.no_sim or is_simulated(profile):
        slow = slower(profile)
    else:
        profile, slow = kept_time(profile)
    profile, secret = _with_secret(profile, options)
    if slow is not None:
        note(slow)
    run(profile, robot, replace(settings, secret=secret))
    return Answer(None)


def experiment(options: argparse.Namespace) -> Answer:
    """``experiment``: by the daemon that runs on this data, else by one of our own."""
    from pa10d.cli.daemon_client import daemon_for, read_plan
    from pa10d.cli.progress import progress_line

    plan = read_plan(options.kind, options.plan, options.settings)
    keys = ("name", "tags", "controller", "model", "replace", "recover")
    chosen = {key: getattr(options, key) for key in keys if getattr(options, key)}

    def before() -> None:
        from pa10d.services.experiments import refuse_wrong_request
        from pa10d.services.library import open_library
        from pa10d.services.robots import load_robot

        robot = load_robot(options.profile)[1]
        refuse_wrong_request(robot, plan["kind"], plan["parameters"])
        if options.model is not None:
            open_library(options.data).models.find(options.model)

    if options.to is not None:
        return _motion_for_others(options, plan)
    with daemon_for(options, before) as client:
        if options.check:
            found = client.check_experiment({**plan, **chosen})
            lines = [f"{c['level']:7s} {c['sentence']}" for c in found["checks"]]
            return Answer(found, "\n".join(lines), status=0 if found["go"] else 1)
        found = client.experiment(plan=plan, progress=progress_line(), **chosen)
    said = [*found.get("notes", ()), *found.get("tuned", ()), *found["recommendation"]]
    for sentence in said:
        note(sentence)
    return Answer(found, "\n".join(found["runs"]))


def _motion_for_others(options: argparse.Namespace, plan: JsonObject) -> Answer:
    """A file of the motion; what the robot's limits forbid is refused as before a run."""
    from pa10d.common.errors import UserError
    from pa10d.diagnose.outcome.settling import NextExperiment
    from pa10d.investigation.doubts import RATE, motion_text
    from pa10d.services.robots import load_robot
    from pa10d.store.folders import write_text

    if not options.to.absolute().parent.is_dir():
        raise UserError(f"--to {options.to}: no such folder, expected one that is there")
    robot = load_robot(options.profile)[1]
    text = motion_text(robot, NextExperiment.read(plan))
    write_text(options.to, text)
    seconds = (text.count("\n") - 2) / RATE
    file = str(options.to.absolute())
    words = f"{file}: {seconds:.1f} s from rest to rest at {RATE:g} Hz, joints in rad (m)"
    return Answer({"file": file, "seconds": seconds, "rate": RATE}, words)


def controller(options: argparse.Namespace) -> Answer:
    """``controller``: asks the daemon that runs on this data."""
    from pa10d.cli.daemon_client import daemon_beside

    with daemon_beside(options, "controller") as client:
        law = options.law or ("computed_torque" if options.model else None)
        robot = client.robot() if law is None else client.use_controller(law, options.model)
    found = {key: robot[key] for key in ("controller", "model", "state")}
    with_model = f" with model {found['model']}" if found["model"] else ""
    return Answer(found, f"{found['controller']}{with_model}; the arm is {found['state']}")


def check(options: argparse.Namespace) -> Answer:
    """``check``."""
    from pa10d.daemon.check import check_robot
    from pa10d.store.location import data_folder

    profile, robot = _as_tuned_here(options)
    found = check_robot(
        _on_bus(profile, options), robot, data_folder(options.data), options.seconds
    )
    go = all(c.level != "error" for c in found)
    lines = [f"{c.level:7s} {c.subject}: {c.sentence}" for c in found]
    document = {"go": go, "checks": [c.document() for c in found]}
    return Answer(document, "\n".join([*lines, "go" if go else "no go"]), 0 if go else 1)


def sim(options: argparse.Namespace) -> Answer:
    """``sim``: until interrupted."""
    from backends.arm_lock import only_arm
    from pa10d.daemon.processes.simulator import serve_arm
    from pa10d.profile import load_profile

    profile = _on_bus(load_profile(options.profile), options)
    with only_arm(profile):
        serve_arm(profile, lambda: note(f"virtual arm on '{profile.can.channel}'"))
    return Answer(None)


def _with_secret(profile: Profile, options: argparse.Namespace) -> tuple[Profile, Secret | None]:
    """The profile whose virtual arm hides what was asked for, and the arm of the next day: what
    happens to an arm happens over night. Nobody is told. The arm that these data were recorded
    from goes on, on the day that it was left, also where nothing is asked for: recordings of two
    arms make a model of none. A seed names another."""
    from secrets import randbelow

    from pa10d.common.errors import UserError
    from pa10d.daemon.night import Drawn, Secret, drawn_before
    from pa10d.daemon.processes.simulator import wants_simulator
    from pa10d.demo.hidden import hide, with_secret
    from pa10d.store.location import data_folder

    named = options.hide is not None and options.seed is not None
    if not wants_simulator(profile) and options.hide is None:
        return profile, None
    try:
        kept = drawn_before(data_folder(options.data))
    except UserError:
        if not named:
            raise
        kept = None
    if options.hide is None:
        if kept is None or kept.profile != profile.name or options.seed is not None:
            if kept is not None and options.seed is not None:
                note(OF_ANOTHER.format(kept))
            return profile, None
        options.hide = kept.hide
    seed = randbelow(10_000) if options.seed is None else options.seed
    drawn = Drawn(profile.name, options.hide, seed)
    if kept is not None and kept.same_arm(
        replace(drawn, seed=kept.seed) if options.seed is None else drawn
    ):
        drawn = kept
        told = (
            f"the virtual arm of seed {kept.seed} goes on, on day {kept.day}, as these data are of "
            "it; --hide with --seed, or another data folder: another one"
        )
    else:
        if kept is not None:
            note(OF_ANOTHER.format(kept))
        told = f"the virtual arm of seed {seed} may hide something, from the start or from day 2 on"
    hidden = hide(None if drawn.hide == "any" else drawn.hide, drawn.seed, profile)
    note(told)
    today, later = (with_secret(profile, hidden, drawn.seed, day) for day in (False, True))
    if hidden.foreign:
        return today, None
    secret = Secret(later, hidden.in_words(), hidden.changes, drawn)
    return later if drawn.day > 1 else today, secret


def _as_tuned_here(options: argparse.Namespace) -> tuple[Profile, Robot]:
    """The profile, of one that is shipped the copy that was tuned with this data."""
    from pa10d.profile import find_profile
    from pa10d.services.robots import load_robot
    from pa10d.services.tuning import own_profile

    path = own_profile(options.data, options.profile)
    if path != find_profile(options.profile):
        note(f"{options.profile} as tuned here: {path}")
    return load_robot(path)


def _on_bus(profile: Profile, options: argparse.Namespace) -> Profile:
    """The profile with the bus and clock of this call."""
    changes: dict[str, object] = {}
    if options.channel:
        changes["can"] = profile.can.model_copy(update={"channel": options.channel})
    if options.clock and profile.simulation:
        changes["simulation"] = profile.simulation.model_copy(update={"clock": options.clock})
    return profile.model_copy(update=changes)
