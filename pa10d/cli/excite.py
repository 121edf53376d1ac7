"""``pa10d excite``: an optimal exciting trajectory, as a plan that can be run."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, note, plain, table
from pa10d.cli.commands import Subcommands, WrongUsage, file_option, positive, profile_option
from pa10d.cli.progress import progress_line
from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject

if TYPE_CHECKING:
    from pa10d.trajectory.excitation.optimise import ExcitingTrajectory


def add_commands(commands: Subcommands) -> None:
    """``excite``."""
    parser = commands.add(
        "excite",
        excite,
        "find a trajectory that excites all parameters",
        examples=(
            "pa10d excite --joints 1-4 --seconds 60 --out traj.yaml",
            "pa10d excite --profile robot.urdf --floor none --out traj.yaml",
        ),
    )
    profile_option(parser)
    add = parser.add_argument
    add("--joints", metavar="A-B", help="such as 1-4 or 1,2,4 (default: all)")
    add("--seconds", type=positive, metavar="S", help="how long the search may take")
    add("--generations", type=int, metavar="N", help="how far to search; repeats exactly")
    add("--seed", type=int, default=1, help="same seed and generations, same result (default: 1)")
    add("--period", type=positive, default=10.0, metavar="S", help="of the motion (default: 10)")
    add("--cycles", type=int, default=3, metavar="N", help="periods to record (default: 3)")
    add("--harmonics", type=int, default=5, metavar="N", help="of the series (default: 5)")
    add("--samples", type=int, default=100, metavar="N", help="of a period (default: 100)")
    add("--floor", metavar="M", help="height in the base frame, or none (default: the profile's)")
    add("--boundary", type=float, nargs="+", metavar="V",
        help="rad/s per joint: only samples above it count")  # fmt: skip
    add("--noise", type=float, nargs="+", metavar="T", help="N·m per joint: weigh by it")
    add("--criterion", choices=("condition", "determinant"), default="condition",
        help="condition number (default), or the determinant of the information")  # fmt: skip
    add("--smallest", type=float, default=0.0, metavar="L2",
        help="weight of 1/σ_min beside the condition number (default: 0)")  # fmt: skip
    add("--even", type=float, default=0.0, metavar="L3",
        help="weight of the worst joint's standard error (default: 0)")  # fmt: skip
    add("--scaled", action="store_true", help="columns to unit norm, so that units do not count")
    add("--workers", type=int, metavar="N", help="processes (default: one per processor)")
    file_option(parser, "out", "write the plan as YAML")


def excite(options: argparse.Namespace) -> Answer:
    """``excite``."""
    import yaml

    from pa10d.services.excitation import excite as search

    if options.out is not None and not options.out.absolute().parent.is_dir():
        raise UserError(f"{options.out}: no such folder {options.out.absolute().parent}")
    found = search(
        options.profile, _joints(options.joints), seconds=options.seconds,
        generations=options.generations, seed=options.seed, cycles=options.cycles,
        workers=options.workers, progress=progress_line(), fundamental=1.0 / options.period,
        harmonics=options.harmonics, samples=options.samples, floor=_floor(options.floor),
        boundary=options.boundary, noise=options.noise, smallest=options.smallest,
        evenness=options.even, scaled=options.scaled,
        determinant=options.criterion == "determinant",
    )  # fmt: skip
    document: JsonObject = plain(found.document())
    for warning in document["about"]["warnings"]:
        note(f"warning: {warning}")
    if options.out is not None:
        text = yaml.safe_dump(document, sort_keys=False, allow_unicode=True)
        options.out.write_text(text, encoding="utf-8")
        note(f"plan: {options.out}")
    answer = {**document["about"], "out": None if options.out is None else str(options.out)}
    if options.out is None:
        answer["plan"] = {key: document[key] for key in ("kind", "parameters")}
    return Answer(answer, _text(found))


def _text(made: ExcitingTrajectory) -> str:
    figures, found = made.figures, made.found
    use = vars(figures.use)
    rows = [
        [
            str(j + 1),
            f"{figures.standard_error[k]:.3g}",
            *(f"{100 * shares[k]:.0f} %" for shares in use.values()),
        ]
        for k, j in enumerate(made.problem.joints)
    ]
    head = ["joint", "standard error at 1 N·m", *(f"of its {limit}" for limit in use)]
    return "\n".join(
        [
            f"condition number {figures.condition_number:.1f} "
            f"({figures.columns} parameters, {figures.equations} equations), smallest singular "
            f"value {figures.smallest_singular_value:.3g}, uneven by {figures.evenness:.1f}",
            table(head, rows),
            f"{found.generations} generations, {found.evaluations} evaluations, "
            f"{found.seconds:.1f} s",
        ]
    )


def _joints(text: str | None) -> list[int] | None:
    if text is None:
        return None
    found: list[int] = []
    try:
        for part in text.split(","):
            first, _, last = part.partition("-")
            found += range(int(first), int(last or first) + 1)
    except ValueError as error:
        raise WrongUsage(f"--joints: found {text!r}, expected such as 1-4 or 1,2,4") from error
    return found


def _floor(text: str | None) -> float | str | None:
    if text is None or text == "none":
        return text
    try:
        return float(text)
    except ValueError as error:
        raise WrongUsage(f"--floor: found {text!r}, expected a height in m or none") from error
