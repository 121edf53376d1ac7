#!/usr/bin/env python3
"""What the diagnosis answers where one of its numbers is halved and doubled.

    sensitivity.py MAP_SHARE CLUSTERS         these constants of pa10d/diagnose/constants.py
    sensitivity.py --out seen.jsonl           all those of whose origin there is no record
    sensitivity.py PASSED_BAND --sets "swings 3" "swings 24"

One line per set whose answer differs from the one with the number as it stands: what is claimed
(findings and unexplained joints) first, then the largest change of a joint's held-out error. Sets:
``freeze.py``'s short ones, and the arm of two links of the tests, clean and with foreign laws; by
name also ``swings 0``, ``swings 1`` …: two links of which one swings at 2 to 12 Hz, every third arm
being stiff.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import bench_real
import numpy as np

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "diagnose"))
import foreign_laws
import test_springs_that_swing as swinging_links
import two_links

from backends.virtual.datasets import figures_of, make_runs, random_effect
from pa10d.diagnose import constants
from pa10d.diagnose.procedure import diagnose
from pa10d.dynamics import robot_from_profile, robot_from_urdf
from pa10d.identify import identify
from pa10d.measurement.recording import Recording
from pa10d.profile import load_profile

SIMULATED = ("none", "stribeck", "torque_ripple", "thermal_friction")
CLEAN = (1, 2, 3, 4)  # seeds of two-link arms without any effect
SWINGS = "swings "
STIFF = 60.0  # Hz, far above what the motion asks of a link
ROOM = ("pa10d.diagnose", "pa10d.report.diagnosis_page")
UNRECORDED = "# -- chosen, on data that nobody"


def main() -> None:
    """Halve and double."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="CONSTANT", help="default: the unrecorded ones")
    parser.add_argument("--factors", nargs="+", type=float, default=[0.5, 2.0])
    parser.add_argument("--sets", nargs="+", metavar="SET", help="fewer sets")
    parser.add_argument("--out", type=Path, help="also as JSON lines")
    args = parser.parse_args()
    asked = {key: case for key, case in cases().items() if not args.sets or key in args.sets}
    for key in args.sets or ():
        if key.startswith(SWINGS):
            asked[key] = cache(lambda key=key: swinging(int(key.removeprefix(SWINGS))))
    standing = {key: told(case) for key, case in asked.items()}
    for name in args.names or unrecorded():
        for factor in args.factors:
            with scaled(name, factor):
                for key, case in asked.items():
                    changed = difference(standing[key], told(case))
                    line = {"constant": name, "factor": factor, "set": key, "changed": changed}
                    if args.out:
                        with args.out.open("a", encoding="utf-8") as file:
                            file.write(json.dumps(line) + "\n")
                    if changed:
                        print(f"{name} × {factor:g}, {key}: {changed}", flush=True)


def unrecorded() -> list[str]:
    """Names below the last heading of the constants."""
    text = Path(constants.__file__).read_text(encoding="utf-8").partition(UNRECORDED)[2]
    return [line.split(" = ")[0] for line in text.splitlines() if line[:1].isupper()]


@contextmanager
def scaled(name: str, factor: float) -> Iterator[None]:
    """One number times a factor, wherever the diagnosis has taken it in."""
    value = getattr(constants, name)
    other = tuple(factor * v for v in value) if isinstance(value, tuple) else factor * value
    if isinstance(value, int):
        other = max(1, round(other))
    rooms = [m for key, m in list(sys.modules.items()) if key.startswith(ROOM) and hasattr(m, name)]
    try:
        for room in rooms:
            setattr(room, name, other)
        yield
    finally:
        for room in rooms:
            setattr(room, name, value)


Case = Callable[[], tuple[Any, list[Any], list[Any]]]


def cases() -> dict[str, Case]:
    """Set -> model, runs to fit and to judge by; made once."""
    out: dict[str, Case] = {f"clean {k}": cache(lambda k=k: small(k)) for k in CLEAN}
    for number, law in enumerate(foreign_laws.LAWS):
        made = law(np.random.default_rng([0, number]))
        out[law.__name__] = cache(lambda k=number, made=made: small(k, made))
    out |= {name: cache(lambda name=name: simulated(name)) for name in SIMULATED}
    if bench_real.DATA.is_dir():
        out["kuka_lwr4"] = cache(real)
    return out


def small(seed: int, extra: Any = None) -> tuple[Any, list[Any], list[Any]]:
    """An arm of two links."""
    runs = two_links.recordings(seed, extra)
    sides = ([runs[f"{kind}_{part}"] for part in "ab"] for kind in ("fit", "valid"))
    return two_links.textbook(runs), *sides


def swinging(number: int) -> tuple[Any, list[Any], list[Any]]:
    """An arm of two links in closed form, one behind a soft spring; every third has none."""
    rng = np.random.default_rng([number, 77])
    joint, hertz = int(rng.integers(0, 2)), float(np.exp(rng.uniform(np.log(2.0), np.log(12.0))))
    zeta = float(rng.uniform(0.02, 0.1))
    if number % 3 == 2:
        joint, hertz, zeta = 0, STIFF, 0.2
    sides = []
    for side, seconds in enumerate((16.0, 10.0)):
        seed = 1000 + 2 * number + side
        rows = swinging_links.recording(seconds, seed, joint, hertz, zeta)[0]
        sides.append([Recording(f"run{side}", rows[:, 0], rows[:, 1:3], rows[:, 3:])])
    robot = robot_from_urdf(swinging_links.urdf(1.0))
    return identify(sides[0], robot, name="m0"), *sides


def simulated(name: str) -> tuple[Any, list[Any], list[Any]]:
    """As ``freeze.py`` draws it."""
    rng = np.random.default_rng([5, sum(name.encode())])
    effects = [] if name == "none" else [random_effect(rng, name, figures_of("pa10-sim"))]
    kinds = ("train_a", "train_b", "valid_a", "valid_b")
    runs, _ = make_runs(5, effects, kinds=kinds, seconds=20.0)
    fit, held = ([runs[f"{kind}_{part}"] for part in "ab"] for kind in ("train", "valid"))
    return identify(fit, robot_from_profile(load_profile("pa10-sim")), name="m0"), fit, held


def real() -> tuple[Any, list[Any], list[Any]]:
    """A real robot."""
    case = bench_real.case("kuka_lwr4")
    return case.identify(), case.train, [case.valid]


def told(case: Case) -> dict[str, Any]:
    """What is claimed, and the held-out error of the last version."""
    found = diagnose(*case())
    return {
        "claims": sorted(
            [f"{found.verdict}"]
            + [f.term.label for f in found.findings]
            + [f"J{u.joint + 1} {'/'.join(u.variables) or 'unnamed'}" for u in found.unexplained]
        ),
        "doubts": sorted(
            f"{f.term.label} ~ {c.effect} {list(c.joints)}"
            for f in found.findings
            for c in f.confounded_with
        ),
        "rms": list(map(float, found.rms)),
        "errors": {
            f"{f.term.label} {name}": float(v.std_error)
            for f in found.findings
            for name, v in f.parameters.items()
        },
    }


def difference(before: dict[str, Any], after: dict[str, Any]) -> str:
    """In words; empty: none."""
    parts = []
    for key in ("claims", "doubts"):
        gone, come = (
            sorted(set(a) - set(b))
            for a, b in ((before[key], after[key]), (after[key], before[key]))
        )
        parts += [f"-{one}" for one in gone] + [f"+{one}" for one in come]
    share = np.array(after["rms"]) / np.array(before["rms"]) - 1.0
    worst = int(np.argmax(np.abs(share)))
    if abs(share[worst]) > 1e-6:
        parts.append(f"RMS of J{worst + 1} {100 * share[worst]:+.2g} %")
    known = {key: value for key, value in before["errors"].items() if value > 0}
    other = {k: after["errors"][k] / v for k, v in known.items() if after["errors"].get(k, 0) > 0}
    key = max(other, key=lambda k: abs(np.log(other[k])), default="")
    if key and abs(np.log(other[key])) > 1e-3:
        parts.append(f"std. error of {key} × {other[key]:.3g}")
    return "; ".join(parts)


if __name__ == "__main__":
    main()
