"""One motion in every kind of file that people have: the same arrays come in."""

from __future__ import annotations

import bz2
import datetime as dt
import gzip
import io
import json
import lzma
import zipfile

import can
import numpy as np
import pytest
from scipy.io import savemat

from pa10d.common.errors import UserError
from pa10d.dynamics import robot_from_urdf
from pa10d.profile import Can, Drive, Profile
from pa10d.readers import read_recording

URDF = """<robot name="two"><link name="base"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l1"><inertial><mass value="3"/><inertia ixx="0.1" iyy="0.1" izz="0.05" ixy="0" ixz="0"
iyz="0"/></inertial></link>
<joint name="elbow" type="revolute"><parent link="l1"/><child link="l2"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="9"/></joint>
<link name="l2"><inertial><mass value="2"/><inertia ixx="0.03" iyy="0.03" izz="0.01" ixy="0"
ixz="0" iyz="0"/></inertial></link></robot>"""
JOINTS = ("shoulder", "elbow")
RATE, SAMPLES = 200.0, 400
DRIVES = [
    {"node": 1 + j, "counts_per_rev": 819200, "gear_ratio": 50, "rated_torque": 2.0}
    for j in range(2)
]


@pytest.fixture(scope="module")
def motion():
    t = np.arange(SAMPLES) / RATE
    q = np.stack([0.4 * np.sin(3 * t), 0.3 * np.cos(2 * t)], axis=1)
    dq = np.gradient(q, 1 / RATE, axis=0)
    tau = 5.0 * np.sin(3 * t)[:, None] * [1.0, 0.4]
    return t, q, dq, tau


def columns(t, q, dq, tau):
    return {"time": t, "q1": q[:, 0], "q2": q[:, 1], "tau1": tau[:, 0], "tau2": tau[:, 1]}


def lines(table, delimiter=",", number=repr, header=None):
    rows = [delimiter.join(header or table)]
    rows += [
        delimiter.join(number(float(v)) for v in row) for row in zip(*table.values(), strict=True)
    ]
    return "\n".join(rows) + "\n"


def decimal_comma(value):
    return repr(value).replace(".", ",")


def text(name, make, mapping=()):
    def write(folder, motion):
        made = make(columns(*motion), motion)
        path = folder / name
        path.write_bytes(made if isinstance(made, bytes) else made.encode())
        return path, mapping

    return write


def renamed(*names):
    return lambda table, motion: lines(dict(zip(names, table.values(), strict=True)))


DEGREES = ("joint_1_position[deg]", "joint_2_position[deg]")


def in_degrees(table, motion):
    t, q, _, tau = motion
    return lines(
        {
            "t": t * 1e3,
            "joint_0_pos": np.degrees(q[:, 0]),
            "joint_1_pos": np.degrees(q[:, 1]),
            "joint_0_trq": tau[:, 0] * 1e3,
            "joint_1_trq": tau[:, 1] * 1e3,
        }
    )


def split_stamps(table, motion):
    t = motion[0] + 1.7e9 + 0.25
    sec = np.floor(t)
    nano = np.rint((motion[0] + 0.25 - np.floor(motion[0] + 0.25)) * 1e9)
    rest = {k: v for k, v in table.items() if k != "time"}
    return lines({"header.stamp.sec": sec, "header.stamp.nanosec": nano, **rest}, ";")


def iso_stamps(table, motion):
    stamps = np.datetime64("2026-03-01T10:00:00", "ns") + np.rint(motion[0] * 1e9).astype(
        "timedelta64[ns]"
    )
    rest = {k: v for k, v in table.items() if k != "time"}
    rows = ["time;" + ";".join(rest)]
    for stamp, *values in zip(stamps, *rest.values(), strict=True):
        rows.append(";".join([f"{stamp}Z", *map(repr, map(float, values))]))
    return "\n".join(rows)


def npz(**blocks):
    def write(folder, motion):
        t, q, dq, tau = motion
        path = folder / "run.npz"
        named = {"time": t, "q": q, "tau": tau} if not blocks else blocks["make"](t, q, dq, tau)
        np.savez(path, **named)
        return path, ()

    return write


def mat(nested=False, new=False):
    def write(folder, motion):
        t, q, dq, tau = motion
        path = folder / "run.mat"
        content = {"time": t[:, None], "q": q, "dq": dq, "tau": tau}
        if new:
            h5py = pytest.importorskip("h5py", reason="no h5py for MAT files of version 7.3")
            with h5py.File(path, "w", userblock_size=512) as file:
                for name, values in content.items():
                    file["/log/" + name if nested else name] = values.T
            with path.open("r+b") as file:
                file.write(b"MATLAB 7.3 MAT-file".ljust(512))
        else:
            savemat(path, {"log": content} if nested else content)
        return path, ()

    return write


def parquet(lists=False, name="run.parquet"):
    def write(folder, motion):
        import pyarrow as pa
        from pyarrow import feather
        from pyarrow import parquet as pq

        t, q, _, tau = motion
        flat = columns(*motion)
        table = {"time": t, "q": q.tolist(), "tau": tau.tolist()} if lists else flat
        path = folder / name
        made = pa.table({k: pa.array(v) for k, v in table.items()})
        (feather.write_feather if name.endswith("feather") else pq.write_table)(made, path)
        return path, ()

    return write


def lerobot(folder, motion):
    import pyarrow as pa
    from pyarrow import parquet as pq

    t, q, _, tau = motion
    path = folder / "set"
    (path / "meta").mkdir(parents=True)
    (path / "data" / "chunk-000").mkdir(parents=True)
    (path / "meta" / "info.json").write_text(json.dumps({"codebase_version": "v3.0"}))
    episode = np.repeat([0, 1], SAMPLES)
    table = {
        "timestamp": np.tile(t, 2),
        "episode_index": episode,
        "observation.state": np.tile(q, (2, 1)).tolist(),
        "observation.effort": np.tile(tau, (2, 1)).tolist(),
    }
    made = pa.table({k: pa.array(v) for k, v in table.items()})
    pq.write_table(made, path / "data" / "chunk-000" / "file-000.parquet")
    return path, ("observation.state{n}=q", "observation.effort{n}=tau")


def bag(kind="sqlite3", single=False, order=(1, 0), extra=True, packed=None):
    """packed: FILE or MESSAGE, by zstd."""

    def write(folder, motion):
        from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore

        t, q, dq, tau = motion
        store = get_typestore(Stores.ROS2_HUMBLE)
        state = store.types["sensor_msgs/msg/JointState"]
        header, stamp = (
            store.types["std_msgs/msg/Header"],
            store.types["builtin_interfaces/msg/Time"],
        )
        path = folder / "bag"
        plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
        writer = Writer(path, version=9, storage_plugin=plugin)
        if packed:
            writer.set_compression(CompressionMode[packed], CompressionFormat.ZSTD)
        with writer:
            link = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
            for k in range(len(t)):
                ns = round(t[k] * 1e9) + 10**18
                who = [*order, None] if extra else list(order)
                pick = [
                    (0.0, 0.0, 0.0) if j is None else (q[k, j], dq[k, j], tau[k, j]) for j in who
                ]
                message = state(
                    header(stamp(ns // 10**9, ns % 10**9), "base"),
                    ["gripper" if j is None else JOINTS[j] for j in who],
                    *(np.array(values) for values in zip(*pick, strict=True)),
                )
                writer.write(link, ns, store.serialize_cdr(message, state.__msgtype__))
        if not single:
            return path, ()
        (file,) = [p for p in path.iterdir() if p.suffix in (".db3", ".mcap")]
        return file, ()

    return write


def split_bag(folder, motion):
    """Two files in one folder, as ``ros2 bag record --max-bag-duration`` leaves them."""
    import yaml

    path, halves = folder / "bag", []
    for k, cut in enumerate((slice(0, SAMPLES // 2), slice(SAMPLES // 2, SAMPLES))):
        (folder / f"half{k}").mkdir()
        halves.append(bag()(folder / f"half{k}", tuple(v[cut] for v in motion))[0])
    path.mkdir()
    whole = yaml.safe_load((halves[0] / "metadata.yaml").read_text())
    info = whole["rosbag2_bagfile_information"]
    info["relative_file_paths"], info["files"], info["message_count"] = [], [], SAMPLES
    for k, half in enumerate(halves):
        (file,) = half.glob("*.db3")
        file.rename(path / f"bag_{k}.db3")
        info["relative_file_paths"].append(f"bag_{k}.db3")
        own = yaml.safe_load((half / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
        info["files"].append({**own["files"][0], "path": f"bag_{k}.db3"})
    info["topics_with_message_count"][0]["message_count"] = SAMPLES
    (path / "metadata.yaml").write_text(yaml.safe_dump(whole))
    return path, ()


def mcap_by_others(folder, motion):
    """One MCAP file of JointState by the mcap library: chunks packed with lz4, no folder."""
    from mcap.writer import CompressionType
    from mcap.writer import Writer as Plain
    from rosbags.typesys import Stores, get_typestore

    t, q, dq, tau = motion
    store = get_typestore(Stores.ROS2_HUMBLE)
    kind = store.types["sensor_msgs/msg/JointState"]
    header, stamp = (
        store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"],
    )  # fmt: skip
    path = folder / "log.mcap"
    with path.open("wb") as file:
        writer = Plain(file, compression=CompressionType.LZ4)
        writer.start(profile="ros2", library="logger")
        definition = store.generate_msgdef(kind.__msgtype__, ros_version=2)[0].encode()
        schema = writer.register_schema(kind.__msgtype__, "ros2msg", definition)
        channel = writer.register_channel("/joint_states", "cdr", schema)
        for k in range(SAMPLES):
            ns = round(t[k] * 1e9) + 10**18
            head = header(stamp(ns // 10**9, ns % 10**9), "")
            message = kind(head, list(JOINTS), q[k].copy(), dq[k].copy(), tau[k].copy())
            data = bytes(store.serialize_cdr(message, kind.__msgtype__))
            writer.add_message(channel, log_time=ns, publish_time=ns, data=data)
        writer.finish()
    return path, ()


def zstd(content):
    import pyarrow as pa

    raw = content if isinstance(content, bytes) else content.encode()
    return bytes(pa.compress(raw, codec="zstd", asbytes=True))


def packed_file(make, ending, pack):
    """Whatever ``make`` writes, packed by somebody who had no idea what it was."""

    def write(folder, motion):
        path, mapping = make(folder, motion)
        out = folder / f"{path.name}{ending}"
        out.write_bytes(pack(path.read_bytes()))
        path.unlink()
        return out, mapping

    return write


def zipped(content):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("run.csv", content)
    return file.getvalue()


def ros1_bag(folder, motion):
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    t, q, dq, tau = motion
    store = get_typestore(Stores.ROS1_NOETIC)
    state = store.types["sensor_msgs/msg/JointState"]
    header, stamp = (
        store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"],
    )  # fmt: skip
    path = folder / "run.bag"
    with Writer(path) as writer:
        link = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
        for k in range(len(t)):
            ns = round(t[k] * 1e9) + 10**18
            head = header(k, stamp(ns // 10**9, ns % 10**9), "")
            message = state(head, list(JOINTS), q[k].copy(), dq[k].copy(), tau[k].copy())
            writer.write(link, ns, store.serialize_ros1(message, state.__msgtype__))
    return path, ()


def without_metadata(make):
    def write(folder, motion):
        path, mapping = make(folder, motion)
        (path / "metadata.yaml").unlink()
        return path, mapping

    return write


def arrow_stream(folder, motion):
    import pyarrow as pa

    path, table = folder / "run.arrows", pa.table(columns(*motion))
    with pa.OSFile(str(path), "wb") as sink, pa.ipc.new_stream(sink, table.schema) as writer:
        writer.write_table(table)
    return path, ()


def records(folder, motion):
    t, q, _, tau = motion
    rows = np.zeros(len(t), dtype=[("time", "f8"), ("q", "f8", (2,)), ("tau", "f8", (2,))])
    rows["time"], rows["q"], rows["tau"] = t, q, tau
    np.save(folder / "run.npy", rows)
    return folder / "run.npy", ()


def plain_array(folder, motion):
    t, q, _, tau = motion
    np.save(folder / "run.npy", np.column_stack([t, q, tau]))
    return folder / "run.npy", ("c1=time", "c2=q1", "c3=q2", "c4=tau1", "c5=tau2")


def hdf5(folder, motion):
    h5py = pytest.importorskip("h5py", reason="no h5py for HDF5")
    t, q, _, tau = motion
    with h5py.File(folder / "run.h5", "w") as file:
        file["time"], file["log/q"], file["log/tau"] = t, q, tau
    return folder / "run.h5", ()


def two_structs(first, second):
    """What was wanted stands beside what was measured, called alike."""

    def write(folder, motion):
        t, q, _, tau = motion
        blocks = {"measured": {"q": q, "tau": tau}, "desired": {"q": q + 1, "tau": tau + 1}}
        log = {"time": t, first: blocks[first], second: blocks[second]}
        savemat(folder / "run.mat", {"log": log})
        return folder / "run.mat", ("log.measured.q{n}=q", "log.measured.tau{n}=tau")

    return write


def simulink(folder, motion):
    """A structure with time."""
    t, q, _, tau = motion
    signals = [{"label": "q", "values": q}, {"label": "tau", "values": tau}]
    savemat(folder / "run.mat", {"out": {"time": t, "signals": signals}})
    return folder / "run.mat", ()


def moments(form, delimiter=","):
    """Stamps in words that a clock would print, beginning shortly before midnight."""

    def make(table, motion):
        begin = dt.datetime(2026, 3, 1, 23, 59, 59, tzinfo=dt.UTC)
        stamps = [begin + dt.timedelta(microseconds=round(v * 1e6)) for v in motion[0]]
        rest = {k: v for k, v in table.items() if k != "time"}
        rows = [delimiter.join(["timestamp", *rest])]
        for stamp, *values in zip(stamps, *rest.values(), strict=True):
            rows.append(delimiter.join([form(stamp), *map(repr, map(float, values))]))
        return "\n".join(rows)

    return make


NAMED = ("timestamp=time",)


def lerobot_with_names(folder, motion):
    path, _ = lerobot(folder, motion)
    features = {
        f"observation.{kind}": {"names": [f"{joint}.{end}" for joint in JOINTS]}
        for kind, end in (("state", "pos"), ("effort", "eff"))
    }
    info = {"codebase_version": "v3.0", "features": features}
    (path / "meta" / "info.json").write_text(json.dumps(info))
    return path, [
        f"observation.{kind}.{joint}.{end}={field}{j}"
        for kind, end, field in (("state", "pos", "q"), ("effort", "eff", "tau"))
        for j, joint in enumerate(JOINTS, 1)
    ]


def two_line_header(table, motion):
    """Names in the first line, units in the second, which are not SI."""
    t, q, _, tau = motion
    turned = {"time": t * 1e3, "pos1": np.degrees(q[:, 0]), "pos2": np.degrees(q[:, 1])}
    turned |= {"trq1": tau[:, 0], "trq2": tau[:, 1]}
    return lines(turned, "\t").replace("\n", "\nms\tdeg\tdeg\tNm\tNm\n", 1)


def can_log(ending):
    def write(folder, motion):
        t, q, _, tau = motion
        path = folder / f"bus{ending}"
        with can.Logger(path) as log:
            for k in range(SAMPLES):
                at = 1000.0 + float(t[k])
                log(can.Message(timestamp=at, arbitration_id=0x80, is_extended_id=False))
                for j in range(2):
                    counts = round(q[k, j] * 819200 / (2 * np.pi))
                    per_mille = round(tau[k, j] * 1000 / 100.0)
                    data = counts.to_bytes(4, "little", signed=True)
                    data += per_mille.to_bytes(2, "little", signed=True) + b"\x27\x06"
                    log(
                        can.Message(
                            timestamp=at + 1e-4 * (j + 1), arbitration_id=0x181 + j, data=data,
                            is_extended_id=False,
                        )
                    )  # fmt: skip
        return path, ()

    return write


FILES = {
    "csv": text("run.csv", lambda c, m: lines(c)),
    "csv.gz": text("run.csv.gz", lambda c, m: gzip.compress(lines(c).encode())),
    "csv.bz2": text("run.csv.bz2", lambda c, m: bz2.compress(lines(c).encode())),
    "csv.zst": text("run.csv.zst", lambda c, m: zstd(lines(c))),
    "semicolons, packed": text("run.csv.bz2", lambda c, m: bz2.compress(lines(c, ";").encode())),
    "semicolons": text("run.csv", lambda c, m: lines(c, ";")),
    "semicolons, decimal comma": text("run.csv", lambda c, m: lines(c, ";", decimal_comma)),
    "tabs": text("run.tsv", lambda c, m: lines(c, "\t")),
    "tabs, decimal comma": text("run.txt", lambda c, m: lines(c, "\t", decimal_comma)),
    "blanks": text("run.dat", lambda c, m: lines(c, "  ")),
    "commented header": text("run.txt", lambda c, m: "# made by a logger\n# " + lines(c, " ")),
    "per cent": text("run.txt", lambda c, m: "% " + lines(c, " ")),
    "utf-16": text("run.csv", lambda c, m: lines(c).encode("utf-16")),
    "byte order mark": text("run.csv", lambda c, m: b"\xef\xbb\xbf" + lines(c).encode()),
    "windows line ends": text("run.csv", lambda c, m: lines(c, ";").replace("\n", "\r\n")),
    "units in a second line": text(
        "run.csv", lambda c, m: lines(c, ";").replace("\n", "\ns;rad;rad;Nm;Nm\n", 1)
    ),
    "two-line header, other units": text(
        "run.tsv", two_line_header,
        ("time[ms]=time", "pos{n}[deg]=q", "trq{n}=tau"),
    ),
    "utf-16, decimal comma": text(
        "run.txt", lambda c, m: lines(c, "\t", decimal_comma).encode("utf-16")
    ),
    "no header": text(
        "run.txt",
        lambda c, m: lines(c, " ").split("\n", 1)[1],
        ("c1=time", "c2=q1", "c3=q2", "c4=tau1", "c5=tau2"),
    ),
    "other names": text(
        "run.csv", renamed("Time", "pos 1", "pos 2", "eff 1", "eff 2"),
        ("Time=time", "pos {n}=q", "eff {n}=tau"),
    ),
    "other units, joints from 0": text(
        "run.csv", in_degrees,
        ("t[ms]=time", "joint_{n-1}_pos[deg]=q", "joint_{n-1}_trq[mNm]=tau"),
    ),
    "other units, not plain": text(
        "run.txt", lambda c, m: in_degrees(c, m).replace(",", ";"),
        ("t[ms]=time", "joint_{n-1}_pos[deg]=q", "joint_{n-1}_trq[mNm]=tau"),
    ),
    "sec and nanosec": text("run.csv", split_stamps),
    "iso stamps": text("run.csv", iso_stamps),
    "npz": npz(),
    "npz, joints first": npz(make=lambda t, q, dq, tau: {"t": t, "q": q.T, "tau": tau.T}),
    "mat": mat(),
    "mat, a struct": mat(nested=True),
    "mat 7.3": mat(new=True),
    "mat 7.3, a struct": mat(new=True, nested=True),
    "parquet": parquet(),
    "parquet, lists": parquet(lists=True),
    "feather": parquet(name="run.feather"),
    "lerobot": lerobot,
    "bag folder, sqlite": bag(),
    "bag folder, mcap": bag("mcap"),
    "bag folder, packed file": bag(packed="FILE"),
    "bag folder, packed messages": bag(packed="MESSAGE"),
    "bag folder, split": split_bag,
    "one .mcap by others": mcap_by_others,
    "one .db3": bag(single=True),
    "one .mcap": bag("mcap", single=True),
    "csv.xz": text("run.csv.xz", lambda c, m: lzma.compress(lines(c).encode())),
    "zip": text("run.zip", lambda c, m: zipped(lines(c))),
    "one .db3, packed": packed_file(bag(single=True), ".zst", zstd),
    "one .mcap, packed": packed_file(bag("mcap", single=True), ".gz", gzip.compress),
    "npz, packed": packed_file(npz(), ".bz2", bz2.compress),
    "bag of ROS 1": ros1_bag,
    "bag folder without metadata": without_metadata(bag("mcap")),
    "bag folder, split, without metadata": without_metadata(split_bag),
    "arrow stream": arrow_stream,
    "npy of records": records,
    "npy": plain_array,
    "hdf5": hdf5,
    "mat, wanted last": two_structs("measured", "desired"),
    "mat, wanted first": two_structs("desired", "measured"),
    "mat of simulink": simulink,
    "iso, commas": text("run.csv", moments(lambda d: f"{d:%Y-%m-%dT%H:%M:%S.%fZ}"), NAMED),
    "iso, a zone": text(
        "run.csv",
        moments(lambda d: d.astimezone(dt.timezone(dt.timedelta(hours=2))).isoformat()),
        NAMED,
    ),
    "days first": text(
        "run.csv", moments(lambda d: f"{d:%d.%m.%Y %H:%M:%S,%f}", ";"), NAMED
    ),
    "time of day": text("run.csv", moments(lambda d: f"{d:%H:%M:%S.%f}"), NAMED),
    "sec and nanosec, commas": text("run.csv", lambda c, m: split_stamps(c, m).replace(";", ",")),
    "units in a second line, commas": text(
        "run.csv", lambda c, m: lines(c).replace("\n", "\ns,rad,rad,Nm,Nm\n", 1)
    ),
    "as a spreadsheet says": text("run.csv", lambda c, m: "sep=;\n" + lines(c, ";", decimal_comma)),
    "lerobot, with names": lerobot_with_names,
    "can .log, packed": packed_file(can_log(".log"), ".xz", lzma.compress),
    "can .log": can_log(".log"),
    "can .asc": can_log(".asc"),
    "can .blf": can_log(".blf"),
    "can .trc": can_log(".trc"),
}  # fmt: skip
COARSE = {"can": (1e-5, 0.06)}  # an encoder's step, a per mille of the rated torque
ROUNDED = {"asc": 1e-4, "trc": 1e-4}  # s, of stamps


def test_there_are_enough_of_them():
    assert len(FILES) >= 30


@pytest.mark.parametrize("kind", FILES)
def test_the_same_motion_comes_in(kind, tmp_path, motion, robot):
    profile, tree = robot
    profile = profile.model_copy(update={"drives": [Drive(**d) for d in DRIVES], "can": Can()})
    _, q, _, tau = motion
    path, mapping = FILES[kind](tmp_path, motion)
    found = read_recording(path, profile, tree, mapping)
    q_step, tau_step = COARSE.get(kind.split()[0], (1e-12, 1e-12))
    assert len(found.samples) == pytest.approx(SAMPLES, abs=2 if "can" in kind else 0)
    assert found.timing.rate == pytest.approx(RATE, rel=1e-3)
    count = min(len(found.samples), SAMPLES)
    assert (
        np.abs(found.samples.q[:count] - q[:count]).max() < 0.02
        if "can" in kind
        else (np.allclose(found.samples.q, q, atol=q_step))
    )
    if "can" not in kind:
        assert np.allclose(found.samples.tau, tau, atol=tau_step)


@pytest.mark.parametrize("alien", [{"is_extended_id": True}, {"is_remote_frame": True}])
def test_foreign_frames_with_a_drive_s_number_are_not_its_own(tmp_path, motion, robot, alien):
    whole, _ = can_log(".blf")(tmp_path, motion)
    mixed = tmp_path / "mixed.blf"
    with can.LogReader(whole) as log, can.Logger(mixed) as out:
        for message in log:
            if message.arbitration_id == 0x181:
                frame = {"arbitration_id": 0x181, "is_extended_id": False, "dlc": 8, **alien}
                data = None if "is_remote_frame" in alien else bytes(8)
                out(can.Message(timestamp=message.timestamp - 1e-5, data=data, **frame))
            out(message)
    profile = robot[0].model_copy(update={"drives": [Drive(**d) for d in DRIVES], "can": Can()})
    expected, found = (read_recording(p, profile, robot[1]).samples for p in (whole, mixed))
    assert np.array_equal(found.q, expected.q)


def test_units_of_a_mapping_reach_the_run(tmp_path, motion, robot):
    path, mapping = FILES["other units, joints from 0"](tmp_path, motion)
    found = read_recording(path, *robot, mapping)
    assert np.abs(found.samples.q).max() == pytest.approx(0.4, rel=1e-3)


def test_a_file_of_strange_names_gets_a_ready_line(tmp_path, motion, robot):
    path, _ = FILES["other units, joints from 0"](tmp_path, motion)
    with pytest.raises(UserError, match=r"perhaps --map ") as caught:
        read_recording(path, *robot)
    assert "joint_{n-1}_pos=q" in str(caught.value)
    assert "t=time" in str(caught.value)


BROKEN = {
    "nothing": (b"", "run.csv", "an empty file"),
    "a picture": (b"\x89PNG\r\n\x1a\n" + bytes(3000), "run.csv", "neither text nor a format"),
    "half a parquet": (b"PAR1" + bytes(200), "run.parquet", "cannot be read"),
    "half an npz": (b"PK\x03\x04" + bytes(99), "run.npz", "cannot be read"),
    "half a mat": (b"MATLAB 5.0 MAT-file" + bytes(300), "run.mat", "cannot be read"),
    "half a bag": (b"SQLite format 3\0" + bytes(200), "run.db3", "cannot be read"),
    "half an mcap": (b"\x89MCAP0\r\n" + bytes(100), "run.mcap", "cannot be read"),
    "half a blf": (b"LOGG" + bytes(40), "run.blf", "cannot be read|frames 0x181"),
    "a gz that ends": (gzip.compress(b"time;q1;q2\n" * 99)[:-9], "run.tsv", "damaged"),
    "rows too short": (b"time;q1;q2;tau1;tau2\n1;2;3\n", "run.csv", ":2: found 3 columns"),
    "a word": (
        b"time;q1;q2;tau1;tau2\n" + b"1;2;3;4;5\n" * 150 + b"1;2;x;4;5\n",
        "run.csv",
        r":152: column 3 \(q2\): found 'x'",
    ),
    "no unit": (b"time;q1;q2;tau1;tau2\n" + b"1;2;3;4;5\n" * 150, "run.csv", "stamp"),
    "an empty folder": (None, "bag", "bag's folder"),
}


@pytest.mark.parametrize("kind", BROKEN)
def test_what_is_broken_is_one_line(kind, tmp_path, robot):
    content, name, says = BROKEN[kind]
    path = tmp_path / name
    if content is None:
        path.mkdir()
    else:
        path.write_bytes(content)
    profile, tree = robot
    profile = profile.model_copy(update={"drives": [Drive(**d) for d in DRIVES]})
    with pytest.raises(UserError, match=says) as caught:
        read_recording(path, profile, tree)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("option", "says"),
    [
        ("q1", "expected COLUMN=FIELD"),
        ("joint_{n}=time", "expected COLUMN=FIELD"),
        ("time[fortnight]=time", "unit 'fortnight', expected a factor"),
        ("nobody=q1", "no column 'nobody'"),
        ("nobody_{n}=q", "no column 'nobody_1'"),
    ],
)
def test_a_mapping_that_does_not_fit(option, says, tmp_path, motion, robot):
    path, _ = FILES["semicolons"](tmp_path, motion)
    with pytest.raises(UserError, match=says):
        read_recording(path, *robot, [option])


def test_a_bag_of_another_robot_names_its_joints(tmp_path, motion, robot):
    path, _ = bag(order=(0,), extra=True)(tmp_path, motion)
    with pytest.raises(UserError, match=r"no joint elbow; found gripper, shoulder"):
        read_recording(path, *robot)


def test_the_urdf_is_sound():
    assert robot_from_urdf(URDF).n == 2
    assert Profile
