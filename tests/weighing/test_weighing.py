"""A weighing from its beginning to gains in a profile and back: what each face calls."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from importlib import import_module
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from backends.scaling import nameplate, scaling_of
from backends.virtual.datasets.runs import run_motion
from backends.virtual.plant import build
from pa10d.cli import main
from pa10d.client import local_daemon
from pa10d.common.errors import UserError
from pa10d.common.jsonable import parsed, plain
from pa10d.daemon.hanging import with_weight
from pa10d.dynamics.robot import robot_from_profile
from pa10d.identify.scale import Body
from pa10d.profile import load_profile
from pa10d.profile.load import find_profile
from pa10d.services.documents import SCHEMAS
from pa10d.services.tuning import ProfileDifference, own_profile, show, undo, versions, write
from pa10d.services.tuning.versions import digest, folder_of
from pa10d.services.weighing import work
from pa10d.services.weighing.apply import apply_gains, undo_gains
from pa10d.services.weighing.archive import Weighings
from pa10d.services.weighing.work import (
    add_weight,
    begin,
    judge,
    refuse_other_gains,
    status,
    weighed,
)
from pa10d.store import Channels, RunStore, Samples, folders
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.poses import Surroundings

TRUE = [1.0, 1.12, 0.9, 1.08, 0.93, 1.1]
WEIGHT = "3+-0.006,0.05,0,0.1"
numbers = count(1)


@pytest.fixture
def mine(tmp_path):
    """A UR5e with a profile of one's own, a comment in it."""
    source = find_profile("ur5e")
    for name in ("ur5e.yaml", "ur5e.urdf"):
        shutil.copy(source.parent / name, tmp_path / name)
    path = tmp_path / "ur5e.yaml"
    path.write_text(path.read_text() + "# the end\n")
    return path


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A data folder with a weighing for which two recordings were made: (data, name, truth)."""
    data = str(tmp_path_factory.mktemp("weighing"))
    state = begin(data, "ur5e", [WEIGHT, "0.2,0.05,0,0.1"], "w")
    for weight in (0, 1):
        weighed(data, state.id, weight, [_record(data, state, weight)])
    return data


def _record(data, state, weight) -> str:
    """What the virtual arm records, without a bus: the same plant, faster than the plan."""
    profile = load_profile("ur5e")
    if weight:
        profile = with_weight(profile, state.body(weight))
    effects = profile.simulation.options.get("effects", ())
    plant = build(profile, effects=effects, seed=weight, torque_gains=TRUE)
    asked = {**state.motion["parameters"], "count": 3, "speed": 0.6}
    request = read_request({"kind": "known_weight", "parameters": asked})
    plan = request.build(Surroundings.of(robot_from_profile(profile)))

    class Course:
        def sample(self, t):
            return plan.at(np.clip(t, 0.0, plan.duration))

    run, _ = run_motion(plant, profile, Course(), plan.duration, 200.0)
    name, channels = f"run-{next(numbers)}", Channels(joints=tuple(profile.joints))
    stamps = (run.t * 1e9).round().astype("int64")
    with RunStore(data).building(name, name, channels, profile) as writer:
        writer.append(Samples(stamps, run.q, run.tau))
    return name


def test_the_way_is_told_step_by_step(tmp_path):
    state = begin(str(tmp_path), "ur5e", ["1,0.05,0,0.1", WEIGHT])
    told = status(state)
    assert told.next.weight == 0
    assert "Take every load off" in told.next.says
    assert told.motion.parameters["mass"] == 3.0, "planned for the heaviest"
    assert any("joint 1: at rest the weight asks nothing" in note for note in told.motion.notes)
    assert Weighings(tmp_path).find(state.name) == state, "what is kept is what was made"


def test_after_the_empty_arm_the_best_weight_is_next_and_then_gains_are_there(recorded):
    state = Weighings(recorded).find("w")
    told = status(state)
    for line, true in list(zip(told.joints, TRUE, strict=True))[1:]:
        assert abs(line.gain - true) < 4 * line.std_error
    assert told.joints[1].std_error < 0.02
    [other] = told.prospects
    assert other.mass == 0.2
    assert told.next.weight == (2 if other.next else None)


def test_another_weight_is_judged_before_it_is_hung(recorded, tmp_path):
    data = shutil.copytree(recorded, tmp_path / "data")
    told = status(add_weight(str(data), "w", "60,0.05,0,0.1"))
    assert told.prospects[-1].too_much is not None


@pytest.mark.long
@pytest.mark.alone
def test_an_analysis_that_was_interrupted_is_made_up_for(recorded, tmp_path, monkeypatch):
    data = str(shutil.copytree(recorded, tmp_path / "data"))
    state = Weighings(data).find("w")
    told = status(state)
    *state.recordings, last = state.recordings
    state.judged = 0
    Weighings(data).save(state)
    judge(data, "w")  # both weights wait

    def killed(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(work, "torque_scale", killed)
    with pytest.raises(KeyboardInterrupt):
        weighed(data, "w", last.weight, last.runs)
    state = Weighings(data).find("w")
    assert state.recordings[-1].runs == last.runs, "what was recorded stays"
    assert state.pending
    assert "not analysed yet" in status(state).next.says
    with local_daemon(data, "ur5e", clock="simulated") as arm:
        for event in arm.events(since=0):
            if event["kind"] == "job" and event["data"]["status"] == "succeeded":
                break
        found = arm.weighing("w")
    assert found["next"] == plain(told.next)
    gains = [[line["gain"] for line in one["joints"]] for one in (found, plain(told))]
    assert gains[0] == pytest.approx(gains[1])


def test_recordings_in_another_scale_are_refused(recorded):
    state, profile = Weighings(recorded).find("w"), load_profile("ur5e")
    refuse_other_gains(state, profile)
    drives = [*profile.drives[:-1], profile.drives[-1].model_copy(update={"torque_gain": 1.1})]
    with pytest.raises(UserError, match=r"w: began with torque gains 1, .* 1, 1\.1 now"):
        refuse_other_gains(state, profile.model_copy(update={"drives": drives}))


def test_gains_are_in_the_profile_and_in_the_weighing_or_in_neither(
    recorded, mine, tmp_path, monkeypatch
):
    data = shutil.copytree(recorded, tmp_path / "data")
    state = Weighings(data).find("w")
    state.profile = str(mine)
    Weighings(data).save(state)
    before = mine.read_bytes()

    def full(*_, **__):
        raise OSError(28, "No space left on device")

    edits = import_module("pa10d.services.tuning.versions")  # a function has that name, too
    for where, what in ((folders.os, "fsync"), (edits, "put_profile")):
        with monkeypatch.context() as disk:
            disk.setattr(where, what, full)
            with pytest.raises(OSError, match="No space left"):
                apply_gains(str(data), "w", [2])
        assert mine.read_bytes() == before
        assert Weighings(data).find("w").applied is None
    assert apply_gains(str(data), "w", [2]).applied.gains.keys() == {"2"}


def test_gains_go_into_the_profile_and_out_again(recorded, mine, tmp_path):
    data = shutil.copytree(recorded, tmp_path / "data")
    state = Weighings(data).find("w")
    state.profile = str(mine)
    Weighings(data).save(state)
    before = mine.read_bytes()
    told = apply_gains(str(data), "w", [2, 3])
    assert told.applied.profile == str(mine)
    text = mine.read_text()
    assert text.endswith("# the end\n")
    assert text.count("torque_gain:") == 2
    drives = load_profile(mine).drives
    assert drives[1].torque_gain == pytest.approx(1.12, abs=0.02)
    assert drives[2].torque_gain == pytest.approx(0.9, abs=0.02)
    assert drives[0].torque_gain == 1.0
    with pytest.raises(UserError, match="applied already"):
        apply_gains(str(data), "w")
    assert "torque gain of joint 2" in versions(str(data), str(mine))[0].changes[0]
    undo_gains(str(data), "w")
    assert mine.read_bytes() == before
    with pytest.raises(UserError, match="nothing was applied"):
        undo_gains(str(data), "w")


@pytest.mark.parametrize("gain", [0.1, 10.0, -1.0])
def test_gains_of_a_weight_that_was_another_one_are_not_applied(recorded, mine, tmp_path, gain):
    data = shutil.copytree(recorded, tmp_path / "data")
    state = Weighings(data).find("w")
    lines = tuple(replace(line, gain=gain) for line in state.result.joints)
    state.profile, state.result = str(mine), replace(state.result, joints=lines)
    Weighings(data).save(state)
    before = mine.read_bytes()
    for joints in ((), (2,)):
        with pytest.raises(UserError, match=f"found a gain of {gain:.3g}: .*; expected"):
            apply_gains(str(data), "w", joints)
    assert mine.read_bytes() == before


def test_a_shipped_profile_gets_a_copy_that_every_command_takes(recorded, tmp_path):
    data = shutil.copytree(recorded, tmp_path / "data")
    shipped = find_profile("ur5e").read_bytes()
    told = apply_gains(str(data), "w")
    assert find_profile("ur5e").read_bytes() == shipped
    own = own_profile(str(data), "ur5e")
    assert str(own) == told.applied.profile
    drives = load_profile(own).drives
    assert drives[3].torque_gain == pytest.approx(1.08, abs=0.05)


def test_the_profiles_own_undo_takes_the_gains_out(recorded, tmp_path):
    data = str(shutil.copytree(recorded, tmp_path / "data"))
    apply_gains(data, "w", [4])
    gain = load_profile(own_profile(data, "ur5e")).drives[3].torque_gain
    looked = undo(data, "ur5e", check=True)
    said = [one.sentence for one in looked.diff if one.asked]
    assert said == [f"torque gain of joint 4: {gain:g} → 1"]
    assert looked.restart, "a powered arm is not to go on with the old gain"
    assert "control has started anew" in looked.effect[0]
    assert parsed(ProfileDifference, plain(looked)) == looked
    assert Weighings(data).find("w").applied is not None
    undo(data, "ur5e", confirmed=True)
    assert load_profile(own_profile(data, "ur5e")).drives[3].torque_gain == 1.0
    assert status(Weighings(data).find("w")).applied is None
    with pytest.raises(UserError, match="nothing was applied"):
        undo_gains(data, "w")
    assert apply_gains(data, "w", [4]).applied.gains == {"4": gain}


class Daemon:
    """One on the same data: what it is asked, and which file it serves."""

    def __init__(self, file, data):
        self.file, self.data, self.asked = file, data, []

    def __enter__(self):
        return self

    def __exit__(self, *error):
        return None

    def tuning(self):
        return {"file": str(self.file)}

    def apply_weighing(self, name, joints):
        self.asked.append(name)
        return plain(apply_gains(self.data, name, joints))

    def let_others_command(self):
        self.asked.append("given back")


@pytest.mark.parametrize("serves_it", [True, False])
def test_the_daemon_of_another_profile_is_left_alone(
    recorded, mine, tmp_path, monkeypatch, serves_it
):
    data = shutil.copytree(recorded, tmp_path / "data")
    state = Weighings(data).find("w")
    state.profile = str(mine)
    Weighings(data).save(state)
    daemon = Daemon(mine if serves_it else mine.parent / "other.yaml", str(data))
    monkeypatch.setattr("pa10d.client.daemons.running_daemon", lambda where: daemon)
    before = mine.read_text()
    assert main(["--data", str(data), "weigh", "apply", "w", "--joints", "2"]) == 0
    assert daemon.asked == (["w", "given back"] if serves_it else [])
    assert mine.read_text() != before


@pytest.fixture
def applied(recorded, mine, tmp_path):
    """A data folder whose weighing has put a gain into a profile of one's own."""
    data = shutil.copytree(recorded, tmp_path / "data")
    state = Weighings(data).find("w")
    state.profile = str(mine)
    Weighings(data).save(state)
    apply_gains(str(data), "w", [2])
    return data


def test_what_was_edited_by_hand_since_is_not_undone(applied, mine):
    mine.write_text(mine.read_text() + "# by hand\n")
    with pytest.raises(UserError, match="changed since the gains were written"):
        undo_gains(str(applied), "w")


def test_what_is_no_profile_is_not_written_whatever_a_weighing_names(applied, tmp_path):
    """A data folder from elsewhere may bring a version of any file whose text it knows."""
    data = applied
    known = tmp_path / "crontab.yaml"
    known.write_text("daily: backup\n")
    state = Weighings(data).find("w")
    brought = folder_of(data, known)
    for file in folder_of(data, Path(state.applied.profile)).glob("*.json"):
        edit = json.loads(file.read_text()) | {"after": digest(known.read_text())}
        (brought / file.name).write_text(json.dumps(edit))
    state.applied = replace(state.applied, profile=str(known))
    Weighings(data).save(state)
    with pytest.raises(UserError, match="crontab"):
        undo_gains(str(data), "w")
    assert known.read_text() == "daily: backup\n"


def test_a_gain_puts_commands_and_readings_right_and_leaves_the_drive_as_it_is():
    drive = load_profile("ur5e").drives[1].model_copy(update={"torque_gain": 1.25})
    assert scaling_of(drive).torque(1000) == pytest.approx(nameplate(drive).torque(1000) / 1.25)
    asked = scaling_of(drive).per_mille(40.0)  # true N·m
    assert nameplate(drive).torque(asked) / 1.25 == pytest.approx(40.0, rel=1e-2)


def test_the_weight_that_a_virtual_arm_hangs_is_as_far_off_as_its_errors_say():
    profile = load_profile("ur5e")
    off = []
    for grams in range(200):
        body = Body(3.0 + grams / 1000, (0.05, 0.0, 0.1), 0.006, (0.002, 0.002, 0.002))
        [entry] = with_weight(profile, body).simulation.options["effects"]
        off.append([(entry["mass"] - body.mass) / 0.006, (entry["cx"] - 0.05) / 0.002])
    again = with_weight(profile, body).simulation.options["effects"][0]
    assert again == entry, "the same weight is the same"
    assert np.std(off, axis=0) == pytest.approx([1.0, 1.0], abs=0.15)
    assert np.abs(np.mean(off, axis=0)).max() < 0.25


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["show", "nobody"], "nobody"),
        (["record", "w", "--with", "9"], "weight 9: expected 0"),
        (["apply", "w", "--joints", "9"], "joint 9: its gain is not determined"),
        (["undo", "w"], "nothing was applied"),
    ],
)
def test_what_cannot_be_weighed_is_one_line(recorded, capsys, words, said):
    assert main(["--data", recorded, "weigh", *words]) == 1
    error = capsys.readouterr().err
    assert said in error
    assert "Traceback" not in error


def test_weights_beside_those_of_a_weighing_that_goes_on_are_wrong_usage(recorded, capsys):
    words = ["guide", "--resume", "w", "--weight", "3,0,0,0"]
    assert main(["--data", recorded, "weigh", *words]) == 2
    assert "--resume" in capsys.readouterr().err


def test_the_command_line_says_it(recorded, capsys):
    assert main(["--data", recorded, "weigh", "show", "w"]) == 0
    text = capsys.readouterr().out
    assert "1.1" in text
    assert "next:" in text
    assert main(["--data", recorded, "--json", "weigh", "show", "w"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "pa10d/weigh-show/1"
    SCHEMAS["weigh-show"].model_validate(found)


def test_the_version_told_is_the_one_that_stands_in_the_file(recorded, mine, tmp_path):
    data = str(shutil.copytree(recorded, tmp_path / "data"))
    state = Weighings(data).find("w")
    state.profile = str(mine)
    Weighings(data).save(state)
    write(data, str(mine), {"limits.velocity": {"1": 1.0}})
    undo(data, str(mine))
    told = apply_gains(data, "w", [2]).version
    assert told == versions(data, str(mine))[0].version == show(data, str(mine)).version
    assert undo_gains(data, "w").version == show(data, str(mine)).version == 1


NOTHING_TOLD = {"joints": [], "prospects": [], "next_mass": None, "advice": ""}


@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        ("weights", ["heavy"], "expected MASS"),
        ("recordings", [{"weight": 7, "runs": ["a"], "when": ""}], "a weight's number"),
        ("id", "another", "expected its folder's"),
        ("seconds", "long", "expected a weighing"),
        ("result", {"prospects": []}, "result.joints: Field required; expected a weighing"),
        ("result", NOTHING_TOLD, "found prospects of 0 weights, expected 1"),
    ],
)
def test_a_damaged_file_is_set_aside(recorded, tmp_path, place, value, said):
    data = shutil.copytree(recorded, tmp_path / "data")
    [file] = (data / "weighings").glob("*/state.json")
    file.write_text(json.dumps({**json.loads(file.read_text()), place: value}))
    archive = Weighings(data)
    assert archive.all() == []
    [aside] = archive.set_aside()
    assert said in aside.reason
    assert "\n" not in aside.reason
