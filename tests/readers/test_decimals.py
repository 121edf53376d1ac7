"""Numbers as spreadsheets and loggers of all countries write them: the right ones, or one line."""

from __future__ import annotations

import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.readers import decimals, read_recording

N = 300
T = np.arange(N) / 200.0
Q = np.stack([0.8 * np.sin(3 * T), 0.6 * np.cos(2 * T)], axis=1)
MILLI = np.rint(5000.0 * np.sin(3 * T)[:, None] * [1.0, 0.4] + 300 * Q).astype(int)
NAMES = ["time", "q1", "q2", "tau1", "tau2"]
MAPPING = ["tau{n}[mNm]=tau"]


def german(text):
    return text.replace(",", "_").replace(".", ",").replace("_", ".")


def thin(text):
    return german(text).replace(".", "\u202f")


WRITTEN = {  # delimiter, positions, torques in mN·m
    "thousands in whole numbers": ("\t", lambda v: f"{v:.9f}", lambda v: f"{v:,}"),
    "thousands with points, decimal commas": (
        ";", lambda v: german(f"{v:.9f}"), lambda v: german(f"{v:,}"),
    ),
    "both signs in one number": (";", lambda v: german(f"{v:.9f}"), lambda v: german(f"{v:,.2f}")),
    "thin spaces": (";", lambda v: thin(f"{v:.9f}"), lambda v: thin(f"{v:,.2f}")),
    "apostrophes": (";", lambda v: f"{v:.9f}", lambda v: f"{v:,.2f}".replace(",", "'")),
    "quoted, between commas": (",", lambda v: f'"{v:.9f}"', lambda v: f'"{v:,.1f}"'),
    "quoted decimal commas between commas": (
        ",", lambda v: f'"{v:.9f}"'.replace(".", ","), lambda v: f'"{v},0"',
    ),
    "a minus that is a dash": (";", lambda v: f"{v:.9f}".replace("-", "\u2212"), str),
    "FORTRAN": ("  ", lambda v: f"{v:.9E}".replace("E", "D"), lambda v: f"{v:.1f}d+00"),
}  # fmt: skip


def file(folder, sign, angle, torque):
    rows = [
        [angle(t), *map(angle, q), *(torque(int(v)) for v in tau)]
        for t, q, tau in zip(T, Q, MILLI, strict=True)
    ]
    path = folder / "run.txt"
    path.write_text("\n".join(sign.join(row) for row in [NAMES, *rows]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("kind", WRITTEN)
def test_the_right_numbers(tmp_path, robot, kind):
    found = read_recording(file(tmp_path, *WRITTEN[kind]), *robot, MAPPING)
    np.testing.assert_allclose(found.samples.q, Q, atol=1e-9)
    np.testing.assert_allclose(found.samples.tau, MILLI / 1000, atol=1e-9)


def test_what_may_be_thousands_or_decimals_is_refused(tmp_path, robot):
    """Groups of three behind commas throughout, and no other sign anywhere."""
    rows = [f"{k};{1 + k // 900},{100 + k % 900};1;2,{100 + k};3" for k in range(N)]
    path = tmp_path / "run.csv"
    path.write_text("\n".join([";".join(NAMES), *rows]) + "\n")
    with pytest.raises(UserError, match=r"column 2 \(q1\): '1,100' may be thousands or have dec"):
        read_recording(path, *robot)


def test_two_signs_in_one_column_are_refused(tmp_path, robot):
    rows = [f"{k / 200};{Q[k, 0]:.4f};1;2;3" for k in range(N)]
    rows[7] = "0.035;0,17;1;2;3"
    path = tmp_path / "run.csv"
    path.write_text("\n".join([";".join(NAMES), *rows]) + "\n")
    with pytest.raises(UserError, match=r"run.csv:9: column 2 \(q1\): found '0,17'"):
        read_recording(path, *robot)


def test_points_with_three_digits_are_decimals_where_nothing_says_otherwise():
    column = [f"{1 + k / 1000:.3f}" for k in range(1, 900)]
    assert decimals.styles_of([column]) == [decimals.Style()]
    assert decimals.styles_of([column, ["0,5"]])[0] == decimals.Style(",", ".")


@pytest.mark.parametrize("form", ["utf-16-be", "utf-16-le", "utf-32"])
def test_letters_of_several_bytes(tmp_path, robot, form):
    path = file(tmp_path, ";", "{:.9f}".format, str)
    path.write_text(path.read_text(), encoding=form)
    np.testing.assert_allclose(read_recording(path, *robot, MAPPING).samples.q, Q, atol=1e-9)


def test_names_and_units_in_comments(tmp_path, robot):
    rows = [f"{t}\t{np.degrees(a)}\t{np.degrees(b)}\t1\t2" for t, (a, b) in zip(T, Q, strict=True)]
    head = ["# arm 7", "# " + "\t".join(NAMES), "# [s]\t[deg]\t[deg]\t[Nm]\t[Nm]"]
    path = tmp_path / "run.txt"
    path.write_text("\n".join([*head, *rows]) + "\n")
    found = read_recording(path, *robot, ["q{n}[deg]=q"])
    np.testing.assert_allclose(found.samples.q, Q, atol=1e-12)


PLOT = [
    "%time", "field.header.seq", "field.header.stamp", "field.header.frame_id", "field.name0",
    "field.name1", *(f"field.{kind}{k}" for kind in ("position", "velocity", "effort")
                     for k in (0, 1)),
]  # fmt: skip


def echoed(folder, names=lambda k: ("elbow", "shoulder"), stamp=10**18 + 5 * 10**8):
    """As ``rostopic echo -p`` writes joint states, in the order of the alphabet."""
    rows = []
    for k in range(N):
        own, came = stamp + 5_000_000 * k if stamp else 0, 10**18 + 5_000_000 * k + 123_000
        row = [came, k, own, "", *names(k), *Q[k, ::-1], *Q[k, ::-1], *(MILLI[k, ::-1] / 1000)]
        rows.append(",".join(map(str, row)))
    path = folder / "run.csv"
    path.write_text("\n".join([",".join(PLOT), *rows]) + "\n")
    return path


@pytest.mark.parametrize("stamp", [10**18 + 5 * 10**8, 0])
def test_rostopic_names_its_joints_in_the_rows(tmp_path, robot, stamp):
    path = echoed(tmp_path, stamp=stamp)
    rules = [
        f"{joint}.{kind}={field}{j}"
        for kind, field in (("position", "q"), ("velocity", "dq"), ("effort", "tau"))
        for j, joint in enumerate(("shoulder", "elbow"), 1)
    ]
    with pytest.raises(UserError, match=r"perhaps --map shoulder.position=q1 elbow.position=q2"):
        read_recording(path, *robot)
    found = read_recording(path, *robot, rules)
    np.testing.assert_array_equal(found.samples.q, Q)
    np.testing.assert_array_equal(found.samples.tau, MILLI / 1000)
    assert found.timing.rate == pytest.approx(200)


def test_rostopic_with_another_order_on_the_way_is_refused(tmp_path, robot):
    path = echoed(tmp_path, lambda k: ("elbow", "shoulder") if k < 50 else ("shoulder", "elbow"))
    with pytest.raises(UserError, match=r"row 51 names shoulder, the first elbow; expected one or"):
        read_recording(path, *robot)


def test_seconds_beside_microseconds(tmp_path, robot):
    rows = [
        f"{1_700_000_000 + k // 200},{k % 200 * 5000},{Q[k, 0]},{Q[k, 1]},1,2" for k in range(N)
    ]
    path = tmp_path / "run.csv"
    path.write_text("\n".join([",".join(["sec", "usec", *NAMES[1:]]), *rows]) + "\n")
    found = read_recording(path, *robot)
    assert found.timing.rate == pytest.approx(200)
    np.testing.assert_array_equal(found.samples.q, Q)
