"""CAN logs of every kind that python-can writes, and folders that somebody packed."""

from __future__ import annotations

import gzip
import importlib.util
import io
import sqlite3
import struct
import tarfile
import zipfile
from contextlib import closing

import can
import numpy as np
import pytest
from test_formats import DRIVES, FILES, URDF, can_log

from pa10d.common.errors import UserError
from pa10d.profile import Can, Drive
from pa10d.readers import Part, read_recording
from pa10d.services.import_preview import preview_recording
from pa10d.services.robots import load_robot
from pa10d.services.runs import import_run
from pa10d.store import RunStore

T = np.arange(400) / 200.0


@pytest.fixture
def motion():
    q = np.stack([0.4 * np.sin(3 * T), 0.3 * np.cos(2 * T)], axis=1)
    return T, q, np.gradient(q, T, axis=0), 5.0 * np.sin(3 * T)[:, None] * [1.0, 0.4]


@pytest.fixture
def robot(tmp_path):
    (tmp_path / "robot.urdf").write_text(URDF)
    profile, tree = load_robot(tmp_path / "robot.urdf")
    return profile.model_copy(update={"drives": [Drive(**d) for d in DRIVES], "can": Can()}), tree


def frames(ending):
    """python-can's own writer of databases loses what it holds when it is stopped at once."""
    if ending != ".db":
        return can_log(ending)

    def write(folder, motion):
        path, _ = can_log(".blf")(folder, motion)
        with can.LogReader(path) as log, closing(sqlite3.connect(folder / "bus.db")) as base, base:
            kinds = "ts REAL, arbitration_id INTEGER, extended INTEGER, remote INTEGER"
            base.execute(f"CREATE TABLE messages ({kinds}, error INTEGER, dlc INTEGER, data BLOB)")
            rows = [(m.timestamp, m.arbitration_id, 0, 0, 0, m.dlc, bytes(m.data)) for m in log]
            base.executemany("INSERT INTO messages VALUES (?, ?, ?, ?, ?, ?, ?)", rows)
        return folder / "bus.db", ()

    return write


@pytest.mark.parametrize("ending", [".csv", ".db", ".blf", ".asc", ".log", ".trc"])
@pytest.mark.parametrize("packed", [False, True])
def test_every_log_of_python_can(tmp_path, motion, robot, ending, packed):
    path, _ = frames(ending)(tmp_path, motion)
    if packed:
        out = tmp_path / "log.zip"
        with zipfile.ZipFile(out, "w") as archive:
            archive.write(path, path.name)
        path = out
    found = read_recording(path, *robot)
    count = min(len(found.samples), 400)
    assert count > 390
    assert np.abs(found.samples.q[:count] - motion[1][:count]).max() < 0.02


@pytest.mark.parametrize(
    ("ending", "other"), [(".csv", ".txt"), (".db", ".db3"), (".db", ".sqlite")]
)
def test_whatever_a_log_is_called(tmp_path, motion, robot, ending, other):
    path, _ = frames(ending)(tmp_path, motion)
    found = read_recording(path.rename(path.with_suffix(other)), *robot)
    assert len(found.samples) > 390


def test_mf4_names_what_it_needs(tmp_path, robot):
    if importlib.util.find_spec("asammdf"):
        pytest.skip("asammdf is installed")
    path = tmp_path / "bus.mf4"
    path.write_bytes(b"MDF     4.10    " + bytes(500))
    with pytest.raises(UserError, match=r"needs asammdf; expected pip install 'pa10d\[mf4\]'"):
        read_recording(path, *robot)


@pytest.mark.parametrize("head", [b"timestamp,arbitration_id,extended,remote,error,dlc,data\n"])
def test_a_log_without_frames_of_the_drives(tmp_path, robot, head):
    path = tmp_path / "bus.csv"
    path.write_bytes(head + b"1.0,0x7ff,0,0,0,1,AA==\n" * 40)
    with pytest.raises(UserError, match=r"joint 1: 0 frames 0x181"):
        read_recording(path, *robot)


def packed(path, out, beside=()):
    """A folder or file as .zip or tar, with what desktops leave beside it."""
    files = [p for p in path.rglob("*") if p.is_file()] if path.is_dir() else [path]
    if out.suffix == ".zip":
        with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in files:
                archive.write(file, file.relative_to(path.parent))
            for name in beside:
                archive.writestr(name, "x")
        return out
    mode = {".gz": "w:gz", ".tgz": "w:gz", ".bz2": "w:bz2", ".xz": "w:xz", ".tar": "w"}[out.suffix]
    with tarfile.open(out, mode) as archive:
        archive.add(path, path.name)
        for name in beside:
            info = tarfile.TarInfo(name)
            info.size = 1
            archive.addfile(info, io.BytesIO(b"x"))
    return out


@pytest.mark.by_default("bag folder, sqlite-bag.tar.gz")
@pytest.mark.parametrize("ending", ["bag.zip", "bag.tar.gz", "bag.tgz", "bag.tar.bz2", "bag.tar"])
@pytest.mark.parametrize("kind", ["bag folder, sqlite", "a LeRobot data set"])
def test_a_packed_folder(tmp_path, motion, robot, ending, kind):
    kind = kind if kind in FILES else next(k for k in FILES if "lerobot" in k.lower())
    path, mapping = FILES[kind](tmp_path, motion)
    out = packed(path, tmp_path / ending, ("__MACOSX/._x", ".DS_Store"))
    found = read_recording(out, *robot, mapping)
    expected = read_recording(path, *robot, mapping)
    np.testing.assert_array_equal(found.samples.q, expected.samples.q)
    info = import_run(RunStore(tmp_path / "data"), out, *robot, mapping=mapping).info
    assert info.name == "bag"


def test_a_bag_without_metadata_in_an_archive(tmp_path, motion, robot):
    path, _ = FILES["bag folder, sqlite"](tmp_path, motion)
    (path / "metadata.yaml").unlink()
    found = read_recording(packed(path, tmp_path / "a.zip", ("notes.txt",)), *robot)
    np.testing.assert_array_equal(found.samples.q, motion[1])


def test_a_file_beside_notes(tmp_path, motion, robot):
    path, _ = FILES["csv"](tmp_path, motion)
    found = read_recording(packed(path, tmp_path / "a.zip", ("README.txt", "setup.png")), *robot)
    np.testing.assert_array_equal(found.samples.q, motion[1])


def evil_tar(path):
    with tarfile.open(path, "w") as archive:
        for name in ("../../out.csv", "a.csv"):
            info = tarfile.TarInfo(name)
            info.size = 1
            archive.addfile(info, io.BytesIO(b"x"))


def two_files(path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.csv", "x")
        archive.writestr("b.csv", "x")


def nothing_in_it(path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.txt", "x")
        archive.writestr("b.png", "x")


def cut_off(path):
    whole = io.BytesIO()
    with tarfile.open(fileobj=whole, mode="w:gz") as archive:
        info = tarfile.TarInfo("a.csv")
        info.size = 300_000
        archive.addfile(info, io.BytesIO(np.random.default_rng(0).bytes(300_000)))
    path.write_bytes(whole.getvalue()[:200_000])


def bomb(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in ("a.csv", "b.txt"):
            archive.writestr(name, bytes(300_000_000))


@pytest.mark.by_default("evil_tar", "two_files", "nothing_in_it", "cut_off")
@pytest.mark.parametrize(
    ("make", "name", "says"),
    [
        (evil_tar, "e.tar", "cannot be unpacked"),
        (two_files, "t.zip", "an archive of 2 files with 2 recordings; expected one recording"),
        (nothing_in_it, "n.zip", "an archive of 2 files with no recording"),
        (cut_off, "c.tar.gz", "cannot be unpacked|damaged"),
        (bomb, "b.zip", "becomes more than"),
    ],
)
def test_an_archive_that_is_refused_in_one_line(tmp_path, robot, make, name, says):
    path = tmp_path / name
    make(path)
    with pytest.raises(UserError, match=says) as caught:
        read_recording(path, *robot)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not (tmp_path.parent / "out.csv").exists()


def answer(number, torque=0):
    """As this program maps it: position, torque, statusword."""
    return struct.pack("<ihH", number, torque, 0x0627)


def bus(
    folder, *, t=T, skip=lambda k, j: False, channels=("can0",), counts=0, sync=True, mapped=answer
):
    """A log of two drives; skip: answers that are not there; counts: where encoders begin; mapped:
    what is in an answer."""
    path = folder / "bus.log"
    q = np.stack([0.4 * np.sin(3 * T), 0.3 * np.cos(2 * T)], axis=1)
    with can.Logger(path) as log:
        for k in range(len(T)):
            for c, channel in enumerate(channels):
                at, frame = 1000.0 + float(t[k]) + 1e-3 * c, {"is_extended_id": False}
                frame["channel"] = channel
                if sync:
                    log(can.Message(timestamp=at, arbitration_id=0x80, **frame))
                for j in (0, 1):
                    if skip(k, j):
                        continue
                    number = round((q[k, j] + c) * 819200 / (2 * np.pi)) + counts
                    number = (number + 2**31) % 2**32 - 2**31
                    data = mapped(number, k % 7 - 3)
                    own = at + 1e-4 * (j + 1)
                    log(can.Message(timestamp=own, arbitration_id=0x181 + j, data=data, **frame))
    return path, q


def test_a_drive_that_stops_ends_the_recording(tmp_path, robot):
    path, q = bus(tmp_path, skip=lambda k, j: j == 1 and k >= 200)
    found = read_recording(path, *robot)
    assert len(found.samples) == 200
    np.testing.assert_allclose(found.samples.q, q[:200], atol=1e-5)
    assert "joint 2.position was not measured all the time: 200 of 400" in found.header_warnings[0]


def test_a_drive_that_begins_late_begins_the_recording(tmp_path, robot):
    path, q = bus(tmp_path, skip=lambda k, j: j == 1 and k < 150)
    np.testing.assert_allclose(read_recording(path, *robot).samples.q, q[150:], atol=1e-5)


def test_a_drive_that_pauses_leaves_a_gap(tmp_path, robot):
    path, q = bus(tmp_path, skip=lambda k, j: j == 1 and 200 < k < 260)
    found = read_recording(path, *robot)
    gap = found.samples.extra["gap"] > 0
    assert gap[205:255].all()
    np.testing.assert_allclose(found.samples.q[~gap], q[~gap], atol=1e-4)


def test_an_answer_belongs_to_the_sync_before_it(tmp_path, robot):
    path, q = bus(tmp_path, skip=lambda k, j: j == 1 and k % 2 == 1)
    found = read_recording(path, *robot)
    np.testing.assert_allclose(found.samples.q, q[::2], atol=1e-5)


def test_drives_that_send_without_sync(tmp_path, robot):
    path, q = bus(tmp_path, sync=False)
    found = read_recording(path, *robot)
    np.testing.assert_allclose(found.samples.q, q[: len(found.samples)], atol=2e-4)


def test_counts_run_over(tmp_path, robot):
    path, q = bus(tmp_path, counts=2**31 - 1000)
    found = read_recording(path, *robot)
    assert not found.wraps
    np.testing.assert_allclose(np.diff(found.samples.q, axis=0), np.diff(q, axis=0), atol=2e-5)


MAPPED = {
    "statusword, position, torque": lambda p, tau: struct.pack("<Hih", 0x1237, p, tau),
    "torque, position, statusword": lambda p, tau: struct.pack("<hiH", tau, p, 0x1237),
    "statusword, torque, position": lambda p, tau: struct.pack("<Hhi", 0x1237, tau, p),
}


@pytest.mark.parametrize("order", MAPPED)
def test_another_mapping_is_told_by_what_is_in_it(tmp_path, robot, order):
    path, q = bus(tmp_path, mapped=MAPPED[order])
    found = read_recording(path, *robot)
    np.testing.assert_allclose(found.samples.q, q, atol=1e-5)
    np.testing.assert_allclose(found.samples.tau[:, 0] / 0.1, np.arange(len(q)) % 7 - 3, atol=1e-9)
    assert f"TPDO 1 holds {order} in this order" in found.header_warnings[0]


NO_STATE = {
    "a speed behind the position": lambda p, tau: struct.pack("<ii", p, 70_000 * tau),
    "big-endian": lambda p, tau: struct.pack(">ihH", p, tau, 0x1237),
    "a temperature": lambda p, tau: struct.pack("<ihh", p, tau, 350),
}


@pytest.mark.parametrize("kind", NO_STATE)
def test_answers_without_a_statusword_are_not_taken_for_torques(tmp_path, robot, kind):
    path, _ = bus(tmp_path, mapped=NO_STATE[kind])
    with pytest.raises(UserError, match=r"no statusword of CiA 402; expected TPDO 1 with 0x6064"):
        read_recording(path, *robot)


def shown(folder, form):
    """The log as candump prints it. form: stamp in s, stamp of the frame before -> words."""
    path, q = bus(folder)
    out, before = [], None
    for line in path.read_text().splitlines():
        stamp, _, frame = line.split()[:3]
        number, data = frame.split("#")
        now = float(stamp[1:-1])
        said = form(now, now if before is None else before)
        pairs = " ".join(data[k : k + 2] for k in range(0, len(data), 2))
        out.append(f" {said}  can0  {number}   [{len(data) // 2}]  {pairs}")
        before = now
    path = folder / "shown.txt"
    path.write_text("\n".join(["# candump any", *out, " (1002.0"]))
    return path, q


STAMPED = {
    "-ta": lambda now, before: f"({now:.6f})",
    "-tz": lambda now, before: f"({now - 1000:010.6f})",
    "-td": lambda now, before: f"({now - before:010.6f})",
    "-tA": lambda now, before: f"(2026-03-01 12:00:{now - 1000:09.6f})",
}


@pytest.mark.parametrize("option", STAMPED)
def test_what_candump_prints_is_read(tmp_path, robot, option):
    path, q = shown(tmp_path, STAMPED[option])
    found = read_recording(path, *robot)
    assert found.timing.rate == pytest.approx(200, rel=1e-3)
    np.testing.assert_allclose(found.samples.q, q, atol=1e-5)


def test_frames_without_stamps_are_refused(tmp_path, robot):
    path, _ = shown(tmp_path, lambda now, before: "")
    with pytest.raises(UserError, match=r"frames without stamps; expected candump -l, -ta or -tz"):
        read_recording(path, *robot)


def test_a_line_that_is_no_frame_is_named(tmp_path, robot):
    path, _ = bus(tmp_path)
    path.write_text(path.read_text().replace("\n", "\nkernel: overrun\n", 1))
    with pytest.raises(UserError, match=r"bus.log: line 2: expected a frame of candump"):
        read_recording(path, *robot)


def test_two_buses_are_not_one(tmp_path, robot):
    path, q = bus(tmp_path, channels=("can0", "can1"))
    with pytest.raises(UserError, match=r"on 2 buses, can0, can1; expected one: --topic can0"):
        read_recording(path, *robot)
    found = read_recording(path, *robot, part=Part(topic="can1"))
    np.testing.assert_allclose(found.samples.q, q + 1, atol=1e-5)
    seen = preview_recording(path, *robot)
    assert seen.problem == "it holds 2 recordings: choose the bus"
    assert (seen.parts.kind, list(seen.parts.options), seen.parts.taken) == (
        "bus", ["can0", "can1"], ""
    )  # fmt: skip
    chosen = preview_recording(path, *robot, part=Part(topic="can1"))
    assert (chosen.problem, chosen.parts.taken) == ("", "can1")
    with pytest.raises(UserError, match=r"no bus can7; found can0, can1"):
        read_recording(path, *robot, part=Part(topic="can7"))


def test_a_clock_that_was_set_back(tmp_path, robot):
    path, _ = bus(tmp_path, t=np.where(np.arange(len(T)) < 200, T, T - 0.3))
    with pytest.raises(UserError, match=r"a frame comes 0.295 s before the one ahead of it"):
        read_recording(path, *robot)


@pytest.mark.parametrize("packed", [False, True])
def test_stamps_since_the_line_before(tmp_path, robot, packed):
    """Vector's option "relative"; lines that hold no frame take their time, too."""
    path, q = bus(tmp_path)
    absolute = tmp_path / "bus.asc"
    with can.LogReader(path) as log, can.Logger(absolute) as out:
        for message in log:
            message.channel = 0
            out(message)
    last, lines = 0.0, []
    for number, line in enumerate(absolute.read_text().splitlines()):
        head, _, rest = line.strip().partition(" ")
        if head.replace(".", "", 1).isdigit():
            now = float(head)
            if number % 7 == 0:
                middle = (last + now) / 2
                lines.append(
                    f" {middle - last:.6f} 1  Statistic: D 10 R 0 XD 0 XR 0 E 0 O 0 B 1.0%"
                )
                last = middle
            line, last = f" {now - last:.6f} {rest}", now
        lines.append(line.replace("timestamps absolute", "timestamps relative"))
    text = "\n".join(lines).encode()
    relative = tmp_path / ("relative.asc.gz" if packed else "relative.asc")
    relative.write_bytes(gzip.compress(text) if packed else text)
    found = read_recording(relative, *robot)
    np.testing.assert_allclose(found.samples.q, q, atol=1e-5)
    assert found.timing.rate == pytest.approx(200.0, rel=1e-3)


def test_answers_that_no_sync_is_before_are_refused(tmp_path, robot):
    path, _ = bus(tmp_path, sync=False)
    end = T[-1] + 1000.0
    syncs = [f"({end + 10 + 0.005 * k:.6f}) can0 080#" for k in range(len(T))]
    path.write_text(path.read_text() + "\n".join(syncs) + "\n")
    with pytest.raises(UserError, match=r"bus.log: joint 1: 0 of \d+ answers come behind a SYNC"):
        read_recording(path, *robot)
