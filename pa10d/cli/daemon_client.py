"""How a command finds a daemon to ask, and shows how far a job is."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, note
from pa10d.cli.commands import WrongUsage, profile_option
from pa10d.cli.progress import progress_line
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject

if TYPE_CHECKING:
    from pa10d.client import Client


def robot_options(parser: argparse.ArgumentParser) -> None:
    """--profile, and on which bus and by which clock its arm is simulated."""
    profile_option(parser)
    parser.add_argument("--channel", help="CAN channel, instead of the profile's")
    parser.add_argument(
        "--clock", choices=("simulated", "real"),
        help="of the virtual arm, instead of the profile's",
    )  # fmt: skip


@contextlib.contextmanager
def daemon_for(
    options: argparse.Namespace, before: Callable[[], None] = lambda: None
) -> Iterator[Client]:
    """The daemon on this data folder; where none runs, one for the time of this command.

    before: called before one is started, to say at once what it would say later."""
    from pa10d.client import START, local_daemon, running_daemon
    from pa10d.daemon.offline import STARTING
    from pa10d.profile import load_profile
    from pa10d.store.location import data_folder

    client = running_daemon(options.data)
    if client is None:
        before()
        load_profile(options.profile)
        data = data_folder(options.data)
        note("no daemon runs on this data: one is started for this command")
        with local_daemon(
            data, options.profile, channel=options.channel, clock=options.clock
        ) as client:
            yield client
        return
    with client:
        robot, wanted = client.robot(), load_profile(options.profile).name
        if robot["profile"] != wanted:
            note(f"the daemon on this data serves {robot['profile']}, not {wanted}")
        if robot["offline_reason"] == STARTING:
            note("the daemon has only just been started: its robot is waited for")
            client.wait_for_robot("inactive", timeout=START)
        try:
            yield client
        finally:
            client.let_others_command()  # such as the next command of the same person


@contextlib.contextmanager
def daemon_beside(options: argparse.Namespace, asked: str) -> Iterator[Client]:
    """The daemon on this data, which must run: what the arm does now is asked of it, and the
    command of the arm given back. asked: the command, as typed."""
    from pa10d.client import running_daemon

    client = running_daemon(options.data)
    if client is None:
        raise UserError(f"{asked}: no daemon runs on this data; expected 'pa10d serve' beside it")
    with client:
        try:
            yield client
        finally:
            client.let_others_command()


def read_plan(kind: str | None, file: Path | None, settings: Sequence[str]) -> JsonObject:
    """``{kind, parameters, …}`` from a file or from what the command line says."""
    from pa10d.common.yamlfile import read_value, read_yaml

    if (kind is None) == (file is None):
        raise WrongUsage("experiment: expected either KIND or --plan FILE")
    given: JsonObject = {}
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not equals:
            raise WrongUsage(f"--set {setting}: expected KEY=VALUE")
        try:
            given[key] = read_value(value, f"--set {key}")
        except UserError as error:
            raise WrongUsage(str(error)) from error
    if file is None:
        return {"kind": kind, "parameters": given}
    plan = read_yaml(file).data
    if "kind" not in plan:
        raise UserError(f"{file}: no 'kind'; expected {{kind: …, parameters: …}}")
    return {**plan, "parameters": {**(plan.get("parameters") or {}), **given}}


def improve_by_daemon(options: argparse.Namespace) -> Answer:
    """``improve --experiments``."""
    with daemon_for(options, lambda: _refuse_wrong_names(options)) as client:
        found = client.improve(
            options.model_, options.fit, options.name, progress_line(),
            validate=options.validate, replace=options.replace, experiments=True,
            smooth=options.smooth, force=options.force,
        )  # fmt: skip
    for entry in found["experiments"]:
        came = ", ".join(entry["runs"]) or f"not run: {entry['error']}"
        note(f"run to settle a doubt: {entry['plan']['kind']} -> {came}")
    made = ", ".join(f"{m['name']} ({m['change']})" for m in found["versions"])
    stored = f"stored: {made}" if made else "nothing stored: there is nothing to add"
    says = [f"{k}. {finding['sentence']}" for k, finding in enumerate(found["findings"], 1)]
    return Answer(found, "\n".join([*says, stored]))


def _refuse_wrong_names(options: argparse.Namespace) -> None:
    from pa10d.services.library import open_library

    library = open_library(options.data)
    library.models.find(options.model_)
    for run in [*options.fit, *options.validate]:
        library.runs.find(run)
    if not options.replace:
        library.models.refuse_taken(options.name)
