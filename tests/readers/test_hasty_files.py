"""Files as people hastily leave them: each comes in right, by itself or by the line that its
refusal ends in, or is refused; never in other numbers."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from short_recording import (
    DQ,
    EPOCH,
    FLAT,
    NS,
    RATE,
    TAU,
    N,
    Q,
    T,
    comes_in_right,
    mapped,
    matlab,
    rows,
    table,
    text,
)
from test_formats import JOINTS

from pa10d.common.errors import UserError
from pa10d.identify import identify
from pa10d.readers import read_recording
from pa10d.services.runs import findings_of, import_run
from pa10d.store import RunStore


def echoed(folder):
    made = [
        [str(ns // 10**9), str(ns % 10**9), "", *JOINTS[::-1], *map(repr, Q[k, ::-1].tolist()),
         *map(repr, DQ[k, ::-1].tolist()), *map(repr, TAU[k, ::-1].tolist())]
        for k, ns in enumerate((NS + EPOCH).tolist())
    ]  # fmt: skip
    path = folder / "echo.csv"
    path.write_text("\n".join(map(",".join, made)) + "\n")
    return path


def by_half_days(folder):
    moments = [f"03/01/2026 {(11 + (59 * 60 + 59 + t) // 3600 - 1) % 12 + 1:02.0f}:"
               f"{int(59 + (59 + t) // 60) % 60:02d}:{(59 + t) % 60:09.6f} "
               f"{'AM' if t < 1 else 'PM'}" for t in T]  # fmt: skip
    return text("run.csv", [moments, *FLAT.values()], ["time", *FLAT])(folder)


def structs(names, *columns):
    out = np.zeros((len(columns[0]),), dtype=[(name, object) for name in names])
    for name, values in zip(names, columns, strict=True):
        out[name] = list(values)
    return out


SAMPLES = [T, *FLAT.values()]
NAMES = ["time", *FLAT]
DEGREES = [T * 1e3, *np.degrees(Q.T), *np.degrees(DQ.T), *TAU.T]
WHOLE = {
    "a report above the names": text(
        "run.csv", SAMPLES, NAMES, ["Robot log 3", "Operator: NN, Hall 2, Cell B", "", "Rate;200"]
    ),
    "one with semicolons": text(
        "run.csv", SAMPLES, NAMES, ["Test;3", "Date;01.03.2026", ""], sign=";"
    ),
    "units in words": text(
        "run.csv", DEGREES, ["time", "q1", "q2", "dq1", "dq2", "tau1", "tau2"],
        below=["msec,degrees,degrees,degrees/s,degrees/s,N m,N m"],
    ),
    "units behind names": text(
        "run.csv", DEGREES, ["time_ms", "q1_deg", "q2_deg", "dq1_deg_s", "dq2_deg_s", "tau1_Nm",
                             "tau2_Nm"],
    ),
    "German": text(
        "run.csv", SAMPLES, ["Zeit", "Winkel_1", "Winkel_2", "Drehmoment_1", "Drehmoment_2"]
    ),
    "noon in half days": by_half_days,
    "ros2 topic echo": echoed,
    "ns since 1970": text("run.csv", [NS + EPOCH, *FLAT.values()], NAMES),
    "µs since 1970, by tabs": text(
        "run.tsv", [(NS + EPOCH) // 1000, *FLAT.values()], ["stamp", *FLAT], sign="\t"
    ),
    "ms since 1970": text("run.csv", [(NS + EPOCH) // 10**6, *FLAT.values()], NAMES),
    "ns in Parquet": table(time=NS + EPOCH, **FLAT),
    "messages in Parquet": table(
        stamp=NS + EPOCH, name=[list(JOINTS[::-1])] * N, position=Q[:, ::-1].tolist(),
        effort=TAU[:, ::-1].tolist(),
    ),
    "a header's stamp in Parquet": table(**{
        "header.stamp.sec": (NS + EPOCH) // 10**9, "header.stamp.nanosec": (NS + EPOCH) % 10**9,
    }, **FLAT),
    "structs in Parquet": table(
        time=T, tau1=TAU[:, 0], tau2=TAU[:, 1],
        position=[{"q1": a, "q2": b} for a, b in Q.tolist()],
    ),
    "a struct a sample": matlab(log=structs(("time", "q", "tau"), T, Q, TAU)),
    "one matrix": matlab(data=np.column_stack([T, Q, TAU])),
    "a clock for each signal": matlab(
        q={"time": T, "signals": {"values": Q}}, tau={"time": T, "signals": {"values": TAU}}
    ),
}  # fmt: skip


def of_labview(head, units=()):
    """A measurement file of LabVIEW: two headers, and a column for remarks that rows do without."""

    def write(folder):
        above = [
            "LabVIEW Measurement",
            "Writer_Version\t2",
            "Separator\tTab",
            *head,
            END,
            "",
            "Channels\t4",
            "Samples\t600\t600\t600\t600",
            *units,
            "X0\t0.0\t0.0\t0.0\t0.0",
            "Delta_X\t0.005\t0.005\t0.005\t0.005",
            END,
        ]
        q = np.degrees(Q) if units else Q
        names = "X_Value\tq1\tq2\ttau1\ttau2\tComment"
        made = rows([T, *q.T, *TAU.T], "\t")
        if any("," in line for line in head):
            made = [row.replace(".", ",") for row in made]
        (folder / "run.lvm").write_text("\n".join([*above, names, *made]) + "\n")
        return folder / "run.lvm"

    return write


END = "***End_of_Header***"
THIRD = np.arange(N) % 3 == 0


def with_rows_of_others(sign, nothing=""):
    """All signals over one clock: rows of another topic hold nothing of the robot."""

    def write(folder):
        made = [sign.join(["__time", *FLAT, "/tf/x"])]
        for k, row in enumerate(rows(SAMPLES, sign)):
            made.append(f"{row}{sign}{nothing}")
            if THIRD[k]:
                made.append(sign.join([str(T[k] + 0.002), *[nothing] * 4, "0.5"]))
        (folder / "run.csv").write_text("\n".join(made) + "\n")
        return folder / "run.csv"

    return write


def with_remarks(encoding):
    """Arrow decodes a remark before it asks what to do with it, and printed its own errors."""

    def write(folder):
        made = [",".join(NAMES), *rows(SAMPLES)]
        made[300:300] = ["# paused at 30 \u00b0C, went on"]
        said = "\n".join([*made, "# the end"]) + "\n"
        (folder / "run.csv").write_text(said, encoding=encoding)
        return folder / "run.csv"

    return write


def with_a_sign_behind(folder):
    made = [",".join(NAMES), *(f"{row}," for row in rows(SAMPLES))]
    (folder / "run.csv").write_text("\n".join(made) + "\n")
    return folder / "run.csv"


def beside_each_signal(values):
    """As a logger of YARP does: joints in an order of its own, told with every signal."""
    names = np.array(JOINTS[::-1], dtype=object)
    block = values[:, ::-1].T.reshape(2, 1, N)
    return {"data": block, "elements_names": names, "timestamps": T + 1.7e9}


WHOLE |= {
    "joints named beside each signal": matlab(robot={
        "description_list": np.array(JOINTS[::-1], dtype=object),
        "joints_state": {"positions": beside_each_signal(Q), "torques": beside_each_signal(TAU)},
    }),
    "words in one": text(
        "run.csv", [(NS + EPOCH) // 10**9, (NS + EPOCH) % 10**9, *Q.T, *(Q + 0.1).T, *TAU.T],
        ["Sec", "NanoSec", *(f"{kind}_{j}" for kind in ("MsrJntPos", "CmdJntPos", "MsrJntTrq")
                             for j in (0, 1))],
    ),
    "LabVIEW": of_labview([]),
    "LabVIEW, units and decimal commas": of_labview(
        ["Decimal_Separator\t,"], ["Y_Unit_Label\tdeg\tdeg\tNm\tNm"]
    ),
    "rows of other signals": with_rows_of_others(","),
    "rows of other signals, semicolons": with_rows_of_others(";"),
    "rows of other signals in Parquet": table(
        time=np.sort([*T, *(T[THIRD] + 0.002)]),
        **{name: np.insert(values, np.flatnonzero(THIRD) + 1, np.nan)
           for name, values in FLAT.items()},
    ),
    "remarks between rows": with_remarks("utf-8"),
    "remarks between rows, Latin-1": with_remarks("latin-1"),
    "a sign behind each value": with_a_sign_behind,
    "an index of seconds without a name": text("run.csv", SAMPLES, ["", *FLAT]),
    "libfranka": text(
        "run.csv", [T, *Q.T, *(Q + 0.1).T, *TAU.T, *(2 * TAU).T],
        ["duration", *(f"state.{one}[{j}]" for one in ("q", "q_d", "tau_J", "tau_J_d")
                       for j in (0, 1))],
    ),
    "a data set of Simulink": matlab(logsout={"Elements": structs(
        ("Name", "Values"), ["q", "tau"],
        [{"Time": T, "Data": Q}, {"Time": T, "Data": TAU}],
    )}),
}  # fmt: skip


@pytest.mark.parametrize("kind", WHOLE)
def test_right_by_itself_or_by_the_line_of_its_refusal(tmp_path, robot, kind):
    comes_in_right(WHOLE[kind](tmp_path), robot)


def test_rows_of_others_are_counted_and_a_line_is_still_the_file_s(tmp_path, robot):
    path = with_rows_of_others(",")(tmp_path)
    mapping = ["__time=time"]
    found = read_recording(path, *robot, mapping)
    assert "200 rows without any position or torque: left" in (found.header_warnings[0])
    made = path.read_text().splitlines()
    made[7] = made[7].replace("0.02,", "0.001,", 1)
    assert made[7].startswith("0.001,"), made[7]
    path.write_text("\n".join(made))
    with pytest.raises(UserError, match=r"run.csv:8: column time: found 0.001 after 0.015"):
        read_recording(path, *robot, mapping)


def test_positions_and_torques_at_different_stamps_are_refused(tmp_path, robot):
    made = ["time,q1,q2,tau1,tau2"]
    for t, q1, q2, tau1, tau2 in zip(*SAMPLES, strict=True):
        made += [f"{t},{q1},{q2},,", f"{t + 0.001},,,{tau1},{tau2}"]
    (tmp_path / "run.csv").write_text("\n".join(made))
    with pytest.raises(UserError, match=r"run.csv:2: column 4 .tau1.: found an empty cell"):
        read_recording(tmp_path / "run.csv", *robot)


def test_a_count_of_rows_is_no_time(tmp_path, robot):
    path = text("run.csv", [np.arange(N), *FLAT.values()], ["", *FLAT])(tmp_path)
    with pytest.raises(UserError, match="no column time; found q1, q2"):
        read_recording(path, *robot)


def test_stamps_are_no_currents(tmp_path, robot):
    """The letters a, m, p stand in "timestamp", too, and there were as many as joints."""
    names = ["time", "position_1", "position_2", "effort_1", "effort_2", "sample_1", "sample_2"]
    path = text("run.csv", [*SAMPLES, T + 5, T + 6], names)(tmp_path)
    with pytest.raises(UserError, match="perhaps --map") as caught:
        read_recording(path, *robot)
    assert "=i" not in str(caught.value)
    found = read_recording(path, *robot, mapped(str(caught.value)))
    assert found.samples.current is None


@pytest.mark.parametrize(
    ("name", "ticks", "period", "line"),
    [
        ("time_ms", 1e3, 2**16, "'time_ms[wrap65536*0.001]=time'"),
        ("t_us", 1e6, 2**32, "'t_us[wrap4294967296*1e-06]=time'"),
        ("time", 1.0, 60.0, "'time[wrap60]=time'"),
    ],
)
def test_a_clock_that_begins_anew_goes_on_by_the_line_of_its_refusal(
    tmp_path, robot, name, ticks, period, line
):
    stamps = np.mod(np.rint(T * 1000) / 1000 * ticks + period - ticks, period)
    path = text("run.csv", [stamps.round(6), *FLAT.values()], [name, *FLAT])(tmp_path)
    first = [] if ticks == 1 else [f"{name}[{'ms' if ticks == 1e3 else 'us'}]=time"]
    with pytest.raises(UserError, match="they begin anew: perhaps --map") as caught:
        read_recording(path, *robot, first)
    assert line in str(caught.value)
    found = read_recording(path, *robot, mapped(str(caught.value)))
    np.testing.assert_allclose(np.diff(found.timing.grid), 0.005, atol=1e-6)
    np.testing.assert_allclose(found.samples.q, Q, atol=1e-6)


def test_a_unit_that_nobody_knows_is_said(tmp_path, robot):
    """A share of the rated torque had been N·m without a word."""
    names = ["time", "q1", "q2", "torque_1[%]", "torque_2[%]"]
    path = text("run.csv", [*SAMPLES[:3], *(10 * TAU).T], names)(tmp_path)
    found = read_recording(path, *robot, ["torque_{n}[%]=tau"])
    assert "torque_1[%] is taken as it is, though % is no unit" in found.header_warnings[0]
    assert "--map 'torque_1[%][FACTOR]=tau1'" in found.header_warnings[0]
    mended = read_recording(path, *robot, ["torque_{n}[%][0.1]=tau"])
    np.testing.assert_allclose(mended.samples.tau, TAU)
    assert mended.header_warnings == []


def twice(folder):
    made = pa.table([pa.array(v) for v in SAMPLES], names=["time", "q1", "q2", "q1", "tau2"])
    parquet.write_table(made, folder / "run.parquet")
    return folder / "run.parquet"


def workbook(folder):
    import zipfile

    with zipfile.ZipFile(folder / "run.xlsx", "w") as archive:
        for name in ("[Content_Types].xml", "xl/workbook.xml", "xl/worksheets/sheet1.xml"):
            archive.writestr(name, "<x/>")
    return folder / "run.xlsx"


def json_lines(folder):
    (folder / "run.jsonl").write_text('{"time": 0.0, "q1": 1.0}\n' * N)
    return folder / "run.jsonl"


REFUSED = {
    "two columns of a name, by tabs": (
        text("run.tsv", SAMPLES, ["time", "q1", "q2", "q1", "tau2"], sign="\t"),
        "columns 2 and 4 are both 'q1'",
    ),
    "two columns of a name, semicolons": (
        text("run.csv", SAMPLES, ["time", "q1", "q2", "tau1", "tau1"], sign=";"),
        "columns 4 and 5 are both 'tau1'",
    ),
    "two columns of a name in Parquet": (twice, r"q1.* expected"),
    "names that change": (
        table(time=T, name=[list(JOINTS if k < 300 else JOINTS[::-1]) for k in range(N)],
              q=Q.tolist(), tau=TAU.tolist()),
        "column name: row 301 names .* expected one order in all rows",
    ),
    "a workbook": (workbook, "an Excel workbook; expected its sheet saved as CSV"),
    "JSON": (json_lines, "JSON; expected a table"),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_one_clear_line(tmp_path, robot, kind):
    write, told = REFUSED[kind]
    path = write(tmp_path)
    with pytest.raises(UserError, match=told) as caught:
        read_recording(path, *robot)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_numbers_of_samples_are_told_from_milliseconds_by_both_lines(tmp_path, robot):
    path = text("run.csv", [np.arange(N), *FLAT.values()], NAMES)(tmp_path)
    found = read_recording(path, *robot)
    profile, arm = robot
    (told,) = [f for f in findings_of(found, "r", arm, profile, delay=False)
               if f.code == "time_unit"]  # fmt: skip
    assert "'time[ms]=time'" in told.advice
    assert "'time[1/RATE]=time'" in told.advice
    again = read_recording(path, *robot, ["time[1/200]=time"])
    assert again.timing.rate == pytest.approx(RATE)


def swinging(seconds, seed):
    t = np.arange(0, seconds, 1 / RATE)
    s = t[:, None] * np.array([2.1, 3.3]) + seed
    q = np.sin(s) + 0.4 * np.cos(2.3 * s)
    ddq = np.stack([np.gradient(np.gradient(c, t), t) for c in q.T], axis=1)
    return t, q, 3.0 * ddq + 8.0 * np.sin(q)


def test_what_was_not_measured_is_in_no_fit(tmp_path, robot):
    """A lost second, filled by a straight line, had been fitted to."""
    profile, arm = robot
    t, q, tau = swinging(20.0, 0.3)
    there = (t < 8.0) | (t > 9.2)
    columns = [t, *q.T, *tau.T]
    whole = text("whole.csv", columns, NAMES)(tmp_path)
    holed = text("holed.csv", [c[there] for c in columns], NAMES)(tmp_path)
    store = RunStore(tmp_path / "data")
    (stretch,) = import_run(store, holed, profile, arm, name="holed", check=True).info.excluded
    assert stretch == pytest.approx((8.0, 9.2), abs=0.02)
    assert import_run(store, whole, profile, arm, name="whole").info.excluded == ()
    fits = [identify([store.recording(name)], arm, name=name) for name in ("whole", "holed")]
    assert np.allclose(fits[1].h, fits[0].h, rtol=1e-3, atol=1e-2)
    straight = store.recording("holed")
    object.__setattr__(straight, "excluded", ())
    bad = identify([straight], arm, name="straight")
    assert np.abs(bad.h - fits[0].h).max() > 10 * np.abs(fits[1].h - fits[0].h).max()
    store.change("holed", excluded=[])
    assert store.recording("holed").excluded == (), "a person's word is the last one"


def test_so_many_pauses_that_nothing_would_be_left(tmp_path, robot):
    t, q, tau = swinging(20.0, 0.3)
    there = np.arange(len(t)) % 40 < 30
    path = text("bursts.csv", [c[there] for c in (t, *q.T, *tau.T)], NAMES)(tmp_path)
    found = read_recording(path, *robot)
    assert len(found.timing.gaps) > 50
    assert found.timing.unmeasured == ()
