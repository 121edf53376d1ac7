"""``pa10d scale``: what one newton metre of the sensors is, by a known weight."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from pa10d.cli.answer import Answer, table
from pa10d.cli.commands import Commands, profile_option
from pa10d.common.errors import UserError

if TYPE_CHECKING:
    import numpy as np

    from pa10d.dynamics.robot import Robot
    from pa10d.measurement.recording import Recording


def add_commands(commands: Commands) -> None:
    """``scale``."""
    parser = commands.add(
        "scale",
        scale,
        "absolute torque gain of every joint, from runs with a known weight",
        examples=(
            "pa10d scale --empty e1 e2 --payload 2.0,0,0,0.1 w1 w2 --profile robot.yaml",
            "pa10d scale --alone --payload 0.49,0,0,-0.1 swing1 swing2 --profile servo.urdf",
        ),
    )
    parser.add_argument("--empty", nargs="+", metavar="RUN", default=[], help="without any weight")
    parser.add_argument(
        "--payload", nargs="+", metavar="BODY RUN", action="append", required=True,
        help="MASS,X,Y,Z (kg, its centre in the last joint's frame, m) and the runs with it; again "
        "for a second weight",
    )  # fmt: skip
    parser.add_argument(
        "--alone", action="store_true",
        help="the weight is all that hangs on the joints (a servo on a bench): no empty run",
    )  # fmt: skip
    profile_option(parser)


def scale(options: argparse.Namespace) -> Answer:
    """``scale``."""
    import numpy as np

    from pa10d.identify.scale import Load, torque_gains
    from pa10d.services.robots import load_robot
    from pa10d.store import RunStore

    _, robot = load_robot(options.profile)
    store = RunStore(options.data)

    def read(names: list[str]) -> list[Recording]:
        runs = [store.recording(store.find(name)) for name in names]
        for name, run in zip(names, runs, strict=True):
            if run.joints != robot.n:
                raise UserError(f"run {name!r}: {run.joints} joints, expected {robot.n}")
        return runs

    if options.alone is bool(options.empty):
        raise UserError(
            "scale: expected --empty RUN, recorded without the weight, or --alone where the weight "
            "is all that the joints carry"
        )
    loads = []
    for body, *names in options.payload:
        if not names:
            raise UserError(f"--payload {body}: no run, expected BODY and the runs with it")
        parameters, mass = _body(body, robot)
        loads.append(Load(read(names), parameters, mass))
    found = torque_gains(robot, read(options.empty), loads)
    rows, lines = [], []
    for j in range(robot.n):
        gain, error = float(found.gain[j]), float(found.std_error[j])
        known = np.isfinite(gain)
        said = f"{gain:.4f} ± {error:.4f}" if known else "the weight asks nothing of it here"
        mend = f"--map 'tau{j + 1}[{1 / gain:.4g}]=tau{j + 1}'" if known and gain else ""
        rows.append([str(j + 1), robot.joint_names[j], said, mend])
        lines.append(
            {
                "joint": j + 1, "gain": gain if known else None,
                "std_error": error if known else None, "map": mend,
            }
        )  # fmt: skip
    if found.next_mass is not None:
        heaviest = max(load.mass for load in loads)
        error = np.nanmax(found.std_error) * heaviest / found.next_mass
        after = f"hang {found.next_mass:g} kg next: the widest error would come to {error:.1%}"
    elif np.isfinite(found.gain).any() and np.nanmax(found.std_error) <= 0.01:
        after = "every gain that can be told is known to 1 %"
    else:
        after = (
            "no heavier weight fits within the torque limits: record longer, or move more slowly"
        )
    head = ["joint", "name", "measured / true torque", "to mend it"]
    document = {"joints": lines, "next_mass": found.next_mass, "advice": after}
    return Answer(document, f"{table(head, rows)}\n{after}")


def _body(text: str, robot: Robot) -> tuple[np.ndarray, float]:
    import numpy as np

    from pa10d.dynamics.robot import rigid_body

    try:
        mass, *com = (float(part) for part in text.split(","))
    except ValueError:
        mass, com = -1.0, []
    if mass <= 0 or len(com) != 3 or not np.isfinite([mass, *com]).all():
        raise UserError(f"--payload {text}: expected MASS,X,Y,Z with a mass above 0")
    parameters = np.zeros((robot.n, 10))
    parameters[-1] = rigid_body(mass, com)
    return parameters, mass
