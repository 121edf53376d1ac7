"""Weighings over HTTP: planned, listed, refused in one line; nothing moves here."""

from __future__ import annotations

import pytest

from pa10d.client import ApiError, Client
from pa10d.profile.load import find_profile
from pa10d.services.weighing.archive import Weighings
from pa10d.services.weighing.work import begin

WEIGHT = "3+-0.006,0.05,0,0.1"


def test_a_weighing_is_planned_shown_and_listed(arm, http):
    begun = arm.begin_weighing([WEIGHT], "planned")
    assert begun["next"]["weight"] == 0
    assert begun["motion"]["kind"] == "known_weight"
    assert arm.weighing("planned")["id"] == begun["id"]
    listed = http.get("/api/v1/weighings").json()
    assert begun["id"] in [one["id"] for one in listed["items"]]
    assert listed["set_aside"] == []
    more = http.post("/api/v1/weighings/planned/weights", json={"weight": "1,0,0,0.1"})
    assert [one["mass"] for one in more.json()["weights"]] == [3.0, 1.0]
    assert not arm.runs(tag="planned")


def test_what_cannot_be_is_refused(http):
    http.post("/api/v1/weighings", json={"weights": [WEIGHT], "name": "refused"})
    for address, body, status, said in [
        ("", {"weights": ["heavy"]}, 400, "expected MASS,X,Y,Z"),
        ("", {"weights": [WEIGHT], "name": "refused"}, 400, "there is one already"),
        ("", {"weights": []}, 422, "weights"),
        ("/nobody/record", {"weight": 0}, 404, "nobody"),
        ("/refused/record", {"weight": 7}, 400, "weight 7: expected 0 (none) to 1"),
        ("/refused/apply", {}, 400, "no gain is determined"),
        ("/refused/undo", None, 400, "nothing was applied"),
    ]:
        answer = http.post(f"/api/v1/weighings{address}", json=body)
        assert answer.status_code == status, (address, answer.text)
        assert said in answer.text


def test_drives_with_other_gains_than_at_the_beginning_are_not_recorded(arm, data_of_arm):
    begun = arm.begin_weighing([WEIGHT], "rescaled")
    archive = Weighings(data_of_arm)
    state = archive.find(begun["id"])
    state.scale = [1.0, 1.25, *state.scale[2:]]
    archive.save(state)
    with pytest.raises(ApiError, match=r"rescaled: began with torque gains 1, 1\.25, 1") as refusal:
        arm.weigh("rescaled", 0)
    assert refusal.value.status == 400
    assert "expected a new weighing" in str(refusal.value)


def test_a_weighing_of_another_file_with_the_same_robot_is_refused(arm, data_of_arm, tmp_path):
    served = find_profile("pa10-sim")
    other = tmp_path / "other.yaml"
    other.write_text(served.read_text().replace("urdf: ", f"urdf: {served.parent}/"))
    begun = begin(str(data_of_arm), str(other), [WEIGHT], "elsewhere")
    assert begun.robot == "pa10-sim"
    for asked in (lambda: arm.weigh("elsewhere", 0), lambda: arm.apply_weighing("elsewhere")):
        with pytest.raises(
            ApiError, match=f"elsewhere is of {other}; this daemon serves .*; expected one"
        ):
            asked()


def test_everybody_is_told_who_commands_for_a_weighing(arm, http):
    arm.begin_weighing([WEIGHT], "told")
    arm.let_others_command()
    http.delete("/api/v1/robot/lease")
    with Client(arm.url, name="weigher") as other, pytest.raises(ApiError, match="nothing was"):
        other.undo_weighing("told")
    with Client(arm.url, name="weigher") as other:
        other.let_others_command()
    with Client(arm.url, name="the last") as last:
        last._ask("PUT", "/api/v1/robot/lease", json={"seconds": 9})
        last.let_others_command()
    holders = []
    for event in arm.events(since=0):
        holders += [event["data"]["holder"]] if event["kind"] == "lease" else []
        if holders[-1:] == ["the last"]:
            break
    assert "weigher" in holders
