"""ROS bags, folders or single files: joint states by name onto the joints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from pa10d.common.errors import UserError
from pa10d.readers.bag_columns import FIELDS, columns_of
from pa10d.readers.bag_rows import BagTopic, Found
from pa10d.readers.mcap_stream import McapStream, is_odd_mcap
from pa10d.readers.packed import first_bytes
from pa10d.readers.part import Parts
from pa10d.readers.signatures import MCAP, ROS1, SQLITE, refuse_stand_in
from pa10d.readers.table import ForeignTable
from pa10d.store.column_guess import was_asked_for

Progress = Callable[[float], None]
EVERY = 100_000  # messages between two words of progress
KINDS = {".mcap": MCAP, ".db3": SQLITE, ".bag": ROS1}
STATES = "sensor_msgs/msg/JointState"
TRAJECTORY = "control_msgs/msg/JointTrajectoryControllerState"
DYNAMIC = "control_msgs/msg/DynamicJointState"
SINGLE = "control_msgs/msg/JointControllerState"
DEGREES_OF_FREEDOM = "control_msgs/msg/MultiDOFStateStamped"


def read_bag(
    path: Path,
    joints: Sequence[str],
    progress: Progress = lambda share: None,
    topic: str | None = None,
) -> ForeignTable:
    """The topic with the most samples of the robot's joints; each joint by its name. Where it lacks
    some, those that have them, as two controllers of one arm publish.

    Where a message has only some of the joints (several senders) the others are taken at its stamps
    by straight lines. progress: called with the share of messages that is read. topic: the one that
    is meant, or several with commas between them, whatever the others hold.
    """
    seen: dict[str, BagTopic] = {}
    remarks: list[str] = []
    try:
        with _as_called(path) as named, _reader(named, remarks) as reader:
            wanted = [c for c in reader.connections if c.msgtype in TAKES]
            if not wanted and getattr(reader, "cut", []):
                raise UserError(
                    f"{path}: cannot be read: it is cut off or damaged before its first message; "
                    "expected a ROS 2 bag"
                )
            if not wanted:
                found = ", ".join(sorted({c.msgtype for c in reader.connections})) or "nothing"
                raise UserError(f"{path}: no {STATES}; found {found}")
            there = {c.topic: 0 for c in wanted}
            for c in wanted:
                there[c.topic] += c.msgcount
            if topic is not None:
                wanted = _of_topics(path, wanted, topic)
            count = max(sum(c.msgcount for c in wanted), 1)
            for k, (connection, stamp, raw) in enumerate(reader.messages(connections=wanted)):
                message = reader.deserialize(raw, connection.msgtype)
                _keep(
                    seen.setdefault(connection.topic, BagTopic()),
                    message,
                    connection.msgtype,
                    stamp,
                )
                if k % EVERY == EVERY - 1:
                    progress(k / count)
            cut = [one.name for one in getattr(reader, "cut", [])]
    except UserError as error:
        raise error if str(path) in str(error) else UserError(f"{path}: {error}") from error
    except Exception as error:  # whatever a damaged bag makes of its reader
        said = (str(error).strip() or type(error).__name__).splitlines()[0][:160]
        raise UserError(f"{path}: cannot be read ({said}); expected a ROS 2 bag") from error
    taken = list(seen) if topic is not None else _taken(seen, joints)
    if not any(seen[name].blocks for name in taken):
        raise UserError(f"{path}: no message on its joint states; expected a recorded motion")
    _refuse_joints_twice(path, {name: seen[name].joints(joints) for name in taken})
    others = ", ".join(sorted(set(seen) - set(taken)))
    kept = {name: seen[name] for name in taken}
    seen.clear()
    unlisted = [] if remarks else _unlisted(path)
    if cut:
        remarks.append(f"{', '.join(cut)}: cut off or damaged, read as far as it is whole")
    if unlisted:
        remarks.append(f"{', '.join(unlisted)}: not in metadata.yaml, left out")
    if len(taken) > 1:
        each = (f"{_listed(kept[name].joints(joints), joints)} from {name}" for name in taken)
        remarks.append(f"joined: {'; '.join(each)}")
    if others:
        remarks.append(f"taken from topic {', '.join(taken)}; left out: {others}")
    parts = _parts(there, taken) if len(there) > 1 else None
    try:
        table = columns_of(path, kept, joints)
    except UserError as error:
        other = [parts.another] if parts and others else []
        raise UserError("; ".join([str(error), *remarks, *other])) from error
    table.remarks += remarks
    table.parts = parts
    return table


def _parts(there: Mapping[str, int], taken: Sequence[str]) -> Parts:
    options = {name: f"{name} · {count} messages" for name, count in there.items()}
    if len(taken) > 1:
        options = {",".join(taken): f"{' + '.join(taken)}, joined"} | options
    return Parts("topic", options, ",".join(taken))


def _of_topics(path: Path, connections: Sequence[Any], topics: str) -> list[Any]:
    """Those of the topics, with or without the stroke that a name begins with."""
    found = []
    for topic in topics.split(","):
        ones = [c for c in connections if c.topic.lstrip("/") == topic.strip().lstrip("/")]
        if not ones:
            there = ", ".join(sorted({connection.topic for connection in connections}))
            raise UserError(f"{path}: no joint states on topic {topic}; found {there}")
        found += [one for one in ones if one not in found]
    return found


def _taken(seen: Mapping[str, BagTopic], joints: Sequence[str]) -> list[str]:
    """The best one; where it lacks joints, others that have none of its own."""
    order = sorted(seen, key=lambda name: _worth(name, seen[name], joints), reverse=True)
    taken = order[:1]
    have = seen[taken[0]].joints(joints) if taken else set()
    for name in order[1:]:
        more = seen[name].joints(joints)
        if have and more and not have & more and not was_asked_for(name):
            taken.append(name)
            have |= more
    return taken


def _refuse_joints_twice(path: Path, topics: Mapping[str, set[str]]) -> None:
    first: dict[str, str] = {}
    for name, joints in topics.items():
        for joint in sorted(joints):
            if joint in first:
                raise UserError(
                    f"{path}: joint {joint} is on {first[joint]} and on {name}; expected each "
                    "joint on one topic"
                )
            first[joint] = name


def _listed(some: set[str], joints: Sequence[str]) -> str:
    return ", ".join(joint for joint in joints if joint in some)


@contextmanager
def _reader(path: Path, remarks: list[str]) -> Iterator[Any]:
    """rosbags' own, or one for MCAP files that it leaves alone. remarks: is told where a bag's
    metadata are damaged, or of a version that rosbags does not know: its files say the same."""
    from rosbags.highlevel import AnyReader, AnyReaderError
    from rosbags.typesys import Stores, get_typestore

    files = sorted(path.glob("*.mcap")) if path.is_dir() else [path]
    for file in (*files, *path.glob("*.db3")):
        refuse_stand_in(file, first_bytes(file, 64))
    if any(map(is_odd_mcap, files)):
        with McapStream(files) as stream:
            yield stream
        return
    types = get_typestore(Stores.ROS2_HUMBLE)
    described = (path / "metadata.yaml").is_file()
    reader = AnyReader([path] if described else _opened(path), default_typestore=types)
    try:
        reader.open()
    except AnyReaderError as error:
        if not described or not any(any(path.glob(f"*{kind}")) for kind in KINDS):
            raise
        said = str(error).strip().splitlines()[0][:120]
        remarks.append(f"its metadata.yaml cannot be used ({said}): read without it")
        reader = AnyReader(_opened(path), default_typestore=types)
        reader.open()
    try:
        yield reader
    finally:
        reader.close()


def _opened(path: Path) -> list[Path]:
    """rosbags opens single files of both kinds; a folder that has lost its metadata is all of its
    files, of one kind."""
    if not path.is_dir():
        return [path]
    kinds = [sorted(path.glob(f"*{kind}")) for kind in (".mcap", ".db3", ".bag")]
    there = [files for files in kinds if files]
    if len(there) != 1:
        files = [file.name for file in sorted(path.iterdir()) if file.is_file()]
        found = f"{', '.join(files[:4])}{' …' if len(files) > 4 else ''}" if files else "no file"
        bags = "bag files of several kinds" if there else "no bag file"
        raise UserError(
            f"{path}: no metadata.yaml and {bags}; found {found}; expected a bag's folder, or "
            "one file"
        )
    return there[0]


@contextmanager
def _as_called(path: Path) -> Iterator[Path]:
    """rosbags tells files by their names: one that is called otherwise gets a name that says what
    is in it, for as long as it is read."""
    head = b"" if path.is_dir() else first_bytes(path, 16)
    kind = next((kind for kind, begin in KINDS.items() if head.startswith(begin)), path.suffix)
    if path.is_dir() or path.suffix == kind:
        yield path
        return
    with TemporaryDirectory(prefix="pa10d-bag-") as folder:
        link = Path(folder) / f"bag{kind}"
        link.symlink_to(path.absolute())
        yield link


def _unlisted(path: Path) -> list[str]:
    """Files of a bag that lie beside the others, and its metadata do not know."""
    meta = path / "metadata.yaml"
    if not meta.is_file():
        return []
    text = meta.read_text(errors="replace")
    files = sorted(one.name for kind in ("*.db3", "*.mcap") for one in path.glob(kind))
    return [name for name in files if name not in text]


def _keep(topic: BagTopic, message: Any, msgtype: str, received: int) -> None:
    stamp = message.header.stamp
    topic.keep(TAKES[msgtype](message), stamp.sec * 1_000_000_000 + stamp.nanosec, received)


def _joint_state(message: Any) -> Found:
    return {kind: (message.name, getattr(message, kind)) for kind in FIELDS}


def _trajectory_state(message: Any) -> Found:
    """``actual`` until Humble, ``feedback`` since; what the controller asked for is left alone."""
    point = getattr(message, "feedback", None) or message.actual
    names = message.joint_names
    return {
        "position": (names, point.positions),
        "velocity": (names, point.velocities),
        "effort": (names, point.effort),
    }


def _dynamic_state(message: Any) -> Found:
    """Each joint has interfaces of its own, by name."""
    found: dict[str, tuple[list[str], list[float]]] = {kind: ([], []) for kind in FIELDS}
    for joint, state in zip(message.joint_names, message.interface_values, strict=True):
        for interface, value in zip(state.interface_names, state.values, strict=True):
            if interface in found:
                found[interface][0].append(joint)
                found[interface][1].append(float(value))
    return dict(found)


def _single_state(message: Any) -> Found:
    """One joint without a name; what it was told to do is its command."""
    name = [message.header.frame_id or "joint"]
    return {
        "position": (name, [message.process_value]),
        "velocity": (name, [message.process_value_dot]),
    }


def _degrees_of_freedom(message: Any) -> Found:
    """Feedback of each degree of freedom; its output is a command, not a measurement."""
    states = message.dof_states
    names = [state.name for state in states]
    return {
        "position": (names, [state.feedback for state in states]),
        "velocity": (names, [state.feedback_dot for state in states]),
    }


TAKES: dict[str, Callable[[Any], Found]] = {
    STATES: _joint_state,
    TRAJECTORY: _trajectory_state,
    DYNAMIC: _dynamic_state,
    SINGLE: _single_state,
    DEGREES_OF_FREEDOM: _degrees_of_freedom,
}


def _worth(name: str, topic: BagTopic, joints: Sequence[str]) -> tuple[bool, int, bool, int]:
    """Measured before asked for, as far as names tell; then joints; then samples."""
    there = {column for block in topic.blocks for column in block.names}
    mine = sum(f"{joint}.effort" in there for joint in joints)
    mine += sum(f"{joint}.position" in there for joint in joints)
    measured = not was_asked_for(name)
    count = sum(len(block.numbers) for block in topic.blocks)
    return measured and mine > 0, mine, measured, count
