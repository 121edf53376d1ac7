"""Before an import: what the columns seem to be, from names, units and ranges, and how to mend."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_broken_kinds import BROKEN
from test_formats import FILES, JOINTS, URDF, can_log, columns, lines

from pa10d.checks import check_recording
from pa10d.cli import main
from pa10d.common.errors import UserError
from pa10d.measurement.recording import Recording
from pa10d.readers import read_recording
from pa10d.services.import_preview import ImportPreview, preview_recording, small_curve
from pa10d.services.mending import mends
from pa10d.services.robots import load_robot
from pa10d.services.runs import import_run
from pa10d.store import RunStore
from pa10d.store.column_choices import Choice, composed, rules_of
from pa10d.store.column_guess import guess, guessed
from pa10d.store.column_mapping import read_unit

T = np.arange(400) / 200.0


@pytest.fixture
def motion():
    q = np.stack([1.2 * np.sin(3 * T), 0.9 * np.cos(2 * T)], axis=1)
    return T, q, np.gradient(q, T, axis=0), 5.0 * np.sin(3 * T)[:, None] * [1.0, 0.4]


@pytest.fixture
def robot(tmp_path):
    (tmp_path / "robot.urdf").write_text(URDF)
    (tmp_path / "robot.yaml").write_text("urdf: robot.urdf\n")
    return load_robot(tmp_path / "robot.yaml")


def written(folder, table, name="log.csv", delimiter=","):
    path = folder / name
    path.write_text(lines(table, delimiter))
    return path


def meant(preview: ImportPreview) -> dict[str, tuple[str, str]]:
    return {column.name: (column.field, column.unit) for column in preview.columns}


def codes(preview: ImportPreview) -> set[str]:
    return {one.finding.code for one in preview.findings}


def test_names_units_and_ranges_make_a_guess(tmp_path, motion, robot):
    t, q, _, tau = motion
    table = {
        "stamp": 1.7e12 + 1e3 * t, "axis 1 pos": np.degrees(q[:, 0]),
        "axis 2 pos": np.degrees(q[:, 1]), "axis 1 torque[mNm]": 1e3 * tau[:, 0],
        "axis 2 torque[mNm]": 1e3 * tau[:, 1], "axis 1 cmd torque": tau[:, 0],
        "axis 2 cmd torque": tau[:, 1], "mode": np.ones(len(t)),
    }  # fmt: skip
    found = preview_recording(written(tmp_path, table), *robot)
    assert found.problem == ""
    assert meant(found) == {
        "stamp": ("time", "ms"), "axis 1 pos": ("q1", "deg"), "axis 2 pos": ("q2", "deg"),
        "axis 1 torque[mNm]": ("tau1", "mNm"), "axis 2 torque[mNm]": ("tau2", "mNm"),
        "axis 1 cmd torque": ("", ""), "axis 2 cmd torque": ("", ""), "mode": ("", ""),
    }  # fmt: skip
    assert found.rules == ["stamp[ms]=time", "axis {n} pos[deg]=q", "axis {n} torque[mNm]=tau"]
    assert found.line == "--map 'stamp[ms]=time' 'axis {n} pos[deg]=q' 'axis {n} torque[mNm]=tau'"
    assert found.rate == pytest.approx(200, rel=1e-3)
    positions = found.columns[1]
    assert positions.first == pytest.approx(np.degrees(q[:5, 0]))
    assert (positions.low, positions.high) == pytest.approx((-1.2, 1.2), rel=1e-4)
    assert max(positions.curve) == pytest.approx(1.2, rel=1e-3)
    assert codes(found) & {"degrees", "time_unit", "commanded"} == set()


@pytest.mark.by_default(
    "csv",
    "semicolons, decimal comma",
    "utf-16",
    "units in a second line",
    "other names",
    "iso stamps",
    "npz",
    "mat, a struct",
    "mat 7.3",
    "parquet",
    "lerobot",
    "bag folder, sqlite",
    "bag folder, mcap",
    "bag of ROS 1",
    "hdf5",
    "can .log",
    "zip",
)
@pytest.mark.parametrize("kind", FILES)
def test_a_preview_is_what_an_import_makes_of_it(kind, tmp_path, motion, robot):
    profile, arm = robot
    if kind.startswith("can"):
        pytest.skip("the readers' test has a profile with drives")
    path, _ = FILES[kind](tmp_path, motion)
    found = preview_recording(path, profile, arm, thorough=False)
    assert found.problem == ""
    if kind.startswith("other units,"):  # torques of N·mm are questioned, not guessed
        (large,) = [f for f in found.findings if f.finding.code == "torque_large"]
        better = {one.column: one for one in large.mends}
        old = [Choice(c.name, c.field, c.unit) for c in found.columns if c.field]
        found = preview_recording(path, profile, arm, [better.get(c.column, c) for c in old])
    stored = RunStore(tmp_path / "data")
    info = import_run(stored, path, profile, arm, mapping=found.rules).info
    assert np.allclose(stored.read(info).samples.q, motion[1], atol=1e-9)
    assert np.allclose(stored.read(info).samples.tau, motion[3], atol=1e-9)


def test_joints_are_known_by_the_robot_s_names(robot):
    names = ["time", "elbow pos", "shoulder pos", "elbow eff", "shoulder eff", "gripper pos"]
    assert {c.column: c.field for c in guessed(names, 2, JOINTS)} == {
        "time": "time", "shoulder pos": "q1", "elbow pos": "q2", "shoulder eff": "tau1",
        "elbow eff": "tau2",
    }  # fmt: skip
    assert guess(["arm1_j1_pos", "arm1_j2_pos", "raw_1_pos"], 2) == ["arm1_j{n}_pos=q"]
    assert guess(["t_ms", "joint0", "joint1", "x1"], 2) == ["t_ms[ms]=time", "joint{n-1}=q"]


def test_what_was_asked_for_and_parts_of_a_torque_are_not_taken_for_measurements():
    """As Franka's arms are logged: q_d and tau_J_d are wanted, tau_ext is a part."""
    kinds = ("q_d", "q", "dq", "tau_J_d", "tau_ext_hat_filtered", "tau_J")
    names = ["t", *(f"{kind}[{j}]" for kind in kinds for j in range(2))]
    rules = ["t=time", "q[{n-1}]=q", "dq[{n-1}]=dq", "tau_J[{n-1}]=tau"]
    assert guess(names, 2) == rules
    names = ["Zeit", *(f"{kind}_{j}" for kind in ("SollWinkel", "Winkel") for j in (1, 2))]
    assert guess(names, 2) == ["Zeit=time", "Winkel_{n}=q"]


@pytest.mark.parametrize(
    ("kinds", "taken"),
    [
        (("qCmd", "qMeas", "tauCmd", "tauMeas"), {"q": "qMeas", "tau": "tauMeas"}),
        (
            ("CmdJntPos", "MsrJntPos", "ExtJntTrq", "MsrJntTrq"),
            {"q": "MsrJntPos", "tau": "MsrJntTrq"},
        ),
        (
            ("thetaDot", "theta", "MotorTorque"),
            {"q": "theta", "dq": "thetaDot", "tau": "MotorTorque"},
        ),
        (("qdd_", "qd_", "q_", "tau_"), {"q": "q_", "dq": "qd_", "tau": "tau_"}),
        (("qDDot", "qDot", "pos", "trq"), {"q": "pos", "dq": "qDot", "tau": "trq"}),
        (("axis_accel", "axis", "torque"), {"q": "axis", "tau": "torque"}),
    ],
)
def test_words_that_are_written_in_one(kinds, taken):
    """What was asked for, speeds and accelerations had been taken for the positions."""
    names = ["time", *(f"{kind}{j}" for kind in kinds for j in (1, 2))]
    found = dict(reversed(rule.split("=")) for rule in guess(names, 2))
    assert {field: column.replace("{n}", "") for field, column in found.items()} == taken


def test_the_joint_s_side_comes_before_the_motor_s():
    kinds = ("motor_pos", "joint_pos", "motor_torque", "link_torque")
    names = ["time", *(f"{kind}_{j}" for kind in kinds for j in (1, 2))]
    assert guess(names, 2) == ["joint_pos_{n}=q", "link_torque_{n}=tau"]
    assert guess(names[:3], 2) == ["motor_pos_{n}=q"]


def test_a_clock_and_units_are_known_by_more_than_one_word():
    assert guess(["sampleTime_ms", "pos_deg1", "pos_deg2"], 2) == [
        "sampleTime_ms[ms]=time", "pos_deg{n}[deg]=q",
    ]  # fmt: skip
    assert guess(["k", "time, s", "q1_mrad", "q2_mrad", "tau1_cNm", "tau2_cNm"], 2) == [
        "time, s=time", "q{n}_mrad[mrad]=q", "tau{n}_cNm[cNm]=tau",
    ]  # fmt: skip


def test_columns_without_names_are_told_by_their_values(tmp_path, motion, robot):
    t, q, dq, tau = motion
    blocks = {"time": t[:, None], "q": q, "wanted": q + 0.001, "dq": dq, "tau": tau}
    path = tmp_path / "log.txt"
    np.savetxt(path, np.hstack(list(blocks.values())))
    line = "c1=time c2=q1 c3=q2 c6=dq1 c7=dq2 c8=tau1 c9=tau2"
    assert preview_recording(path, *robot).rules == line.split()
    with pytest.raises(UserError, match=rf"or --map {line} \(9 columns\)"):
        read_recording(path, *robot)


def test_a_refusal_knows_the_joints_by_name_and_what_currents_need(tmp_path, motion, robot):
    t, q, _, tau = motion
    names = [f"/joint_states/{joint}/{what}" for what in ("position", "effort") for joint in JOINTS]
    table = dict(zip(["__time", *names], [t, *q.T, *tau.T], strict=True))
    with pytest.raises(UserError, match="perhaps --map __time=time /joint_states/shoulder/pos"):
        read_recording(written(tmp_path, table), *robot)
    table = {"time": t, "pos1": q[:, 0], "pos2": q[:, 1], "amps1": tau[:, 0], "amps2": tau[:, 1]}
    with pytest.raises(UserError, match="motor currents need 'torque_constants'"):
        read_recording(written(tmp_path, table), *robot)


def test_torques_that_were_asked_for_are_named_where_there_are_no_others(tmp_path, motion, robot):
    t, q, _, tau = motion
    table = {"time": t, "q1": q[:, 0], "q2": q[:, 1], "torque_cmd_1": tau[:, 0]}
    path = written(tmp_path, table | {"torque_cmd_2": tau[:, 1]})
    with pytest.raises(UserError, match=r"asked for, not measured, .* 'torque_cmd_\{n\}=tau'$"):
        read_recording(path, *robot)


def test_what_holds_no_numbers_is_said(tmp_path, motion, robot):
    path = written(tmp_path, columns(*motion), delimiter=";")
    rows = path.read_text().splitlines()
    path.write_text("\n".join([f"{rows[0]};mode", *(f"{row};auto" for row in rows[1:])]))
    assert preview_recording(path, *robot).remarks == ["log.csv: no numbers in mode: left out"]


def test_a_choice_is_corrected_and_what_is_wrong_is_said(tmp_path, motion, robot):
    path = written(tmp_path, dict(zip("abcde", columns(*motion).values(), strict=True)))
    found = preview_recording(path, *robot)
    assert found.rules == []
    assert found.problem.startswith("log.csv: no column time, q1, q2, tau1, tau2; found a, b")
    assert found.columns[0].first == [0, 0.005, 0.01, 0.015, 0.02]
    fields = ("time", "q1", "q2", "tau1", "tau2")
    right = [Choice(c, f) for c, f in zip("abcde", fields, strict=True)]
    assert preview_recording(path, *robot, right).problem == ""
    twice = [*right[:2], Choice("c", "q1")]
    assert "expected each column and field once" in preview_recording(path, *robot, twice).problem
    odd = [Choice("a", "time", "fortnight"), *right[1:]]
    assert "unit 'fortnight', expected a factor" in preview_recording(path, *robot, odd).problem
    (tmp_path / "none.csv").write_text("")
    with pytest.raises(UserError, match="an empty file"):
        preview_recording(tmp_path / "none.csv", *robot)


def test_the_profile_s_mapping_comes_first(tmp_path, motion, robot):
    profile, arm = robot
    path = written(tmp_path, dict(zip("abcde", columns(*motion).values(), strict=True)))
    keep = ["a=time", "b=q1", "c[-1]=q2", "d=tau1", "e=tau2"]
    import_run(RunStore(tmp_path / "data"), path, profile, arm, mapping=keep)
    found = preview_recording(path, load_robot(tmp_path / "robot.yaml")[0], arm)
    assert found.rules == keep
    assert meant(found)["c"] == ("q2", "-1")


def test_what_mends_a_finding_is_a_choice(tmp_path, motion, robot):
    t, q, dq, tau = motion
    table = {"time": t, "pos1": np.degrees(q[:, 0]), "pos2": np.degrees(q[:, 1])}
    table |= {"dq1": dq[:, 0], "dq2": dq[:, 1]}
    table |= {"tau1": np.mod(np.rint(5e3 * np.sin(9 * t)), 65536), "tau2": tau[:, 1]}
    path = written(tmp_path, table)
    chosen = [Choice("pos1", "q1", "-1"), Choice("pos2", "q2", "-1")]
    wrong = preview_recording(path, *robot, chosen, thorough=False)
    by_code = {one.finding.code: one for one in wrong.findings}
    degrees = {(c.column, c.field, c.unit) for c in by_code["degrees"].mends}
    assert degrees == {("pos1", "q1", "-1*deg"), ("pos2", "q2", "-1*deg")}
    assert "--map 'pos{n}[-1*deg]=q'" in by_code["degrees"].finding.advice
    assert by_code["wrapped"].mends == [Choice("tau1", "tau1", "i16")]
    assert meant(preview_recording(path, *robot))["tau1"] == ("tau1", "i16")


def test_what_mends_does_not_hang_on_the_words_of_an_advice(motion):
    t, q, dq, tau = motion
    finding = next(f for f in check_recording(Recording("r", t, np.degrees(q), tau, dq))
                   if f.code == "degrees")  # fmt: skip
    for said in (finding, replace(finding, advice="bitte in Radiant")):
        assert mends(said, {"q1": "a", "q2": "b"}, {"a": "-1"}, 2) == [
            Choice("a", "q1", "-1*deg"), Choice("b", "q2", "deg"),
        ]  # fmt: skip
    assert "mends" not in finding.document()


def test_units_are_put_together():
    for old, new in (("deg", "-1"), ("-deg", "-1"), ("-1", "-1"), ("", "i16"), ("deg", "1/100")):
        both = composed(old, new)
        factor = (read_unit(old).factor if old else 1.0) * read_unit(new).factor
        assert (read_unit(both).factor if both else 1.0) == pytest.approx(factor)
    assert composed("1", "deg") == composed("", "deg") == "deg"
    assert composed("-deg", "deg") == "-deg"  # a finding on other joints says it once more
    assert rules_of([Choice("q[deg]", "q1"), Choice("tau", "tau1", "Nmm")], 1) == [
        "q[deg][1]=q1", "tau[Nmm]=tau1",
    ]  # fmt: skip


def test_a_small_curve_touches_every_extreme():
    values = np.sin(np.arange(5000) / 300.0)
    values[[700, 3100]] = 9.0, -7.0
    curve = small_curve(values)
    assert len(curve) == 120
    assert (max(curve), min(curve)) == (9.0, -7.0)
    assert small_curve(values[:50]) == pytest.approx(values[:50], rel=1e-3)


def test_a_can_log_needs_no_mapping(tmp_path, motion, robot):
    path, _ = can_log(".blf")(tmp_path, motion)
    with pytest.raises(UserError, match="a CAN log needs a profile with 'drives'"):
        preview_recording(path, *robot)


def test_the_command_line_shows_the_same(tmp_path, motion, robot, capsys):
    t, q, _, tau = motion
    table = {"t": t, "u1": np.degrees(q[:, 0]), "u2": np.degrees(q[:, 1])}
    path = written(tmp_path, table | {"trq1": tau[:, 0], "trq2": tau[:, 1]})
    words = ["--data", str(tmp_path / "data"), "run", "preview", str(path)]
    words += ["--profile", str(tmp_path / "robot.yaml")]
    assert main(words) == 1
    told = capsys.readouterr().out
    assert "trq1" in told
    assert "no column q1, q2" in told
    line = ["--map", "u{n}[deg]=q"]
    assert main([*words, *line]) == 0
    told = capsys.readouterr().out
    assert "--map t=time 'u{n}[deg]=q' 'trq{n}=tau'" in told
    assert not (tmp_path / "data" / "runs").exists()


@pytest.mark.parametrize("kind", BROKEN)
def test_what_is_broken_is_one_line(kind, tmp_path):
    content, name, _ = BROKEN[kind]
    path = tmp_path / name
    path.write_bytes(content)
    try:
        found = preview_recording(path, *load_robot("ur5e"), thorough=False)
        said = found.problem
        found.document()
    except UserError as error:
        said = str(error)
    assert name in said
    assert "\n" not in said
