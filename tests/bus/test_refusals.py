"""A cause that several axes share is said once, with all their joints."""

from backends.faults import refusal


def test_what_is_common_is_said_once():
    found = refusal("setup", {0: "no bus", 1: "no bus", 2: "wrong mode", 4: "no bus"})
    assert found.axes == (0, 1, 2, 4)
    assert found.axis is None
    said = str(found)
    assert "joints 1, 2 and 5: no bus" in said
    assert "joint 3: wrong mode" in said
    assert said.count("no bus") == 1


def test_one_axis_keeps_its_number():
    found = refusal("setup", {3: "wrong mode"})
    assert found.axis == 3
    assert "joint 4: wrong mode" in str(found)
