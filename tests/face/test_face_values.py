"""The values of the public face: compared by content, never changed, short to read."""

from __future__ import annotations

import inspect
import pydoc
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pa10d


def swing(seed=0, joints=2, rate=100.0, seconds=4.0):
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * rate)) / rate
    q = np.sin(np.outer(t, 1.0 + np.arange(joints)))
    return t, q, rng.normal(size=q.shape)


def test_equal_content_is_equal():
    t, q, tau = swing()
    one, same = pa10d.Run(t, q, tau), pa10d.Run(t.copy(), q.tolist(), tau)
    assert one == same
    assert hash(one) == hash(same)
    assert one != pa10d.Run(t, q, tau + 1e-12)
    assert one != pa10d.Run(t, q, tau, name="another")
    assert {one: 1}[same] == 1


def test_nothing_can_be_changed():
    t, q, tau = swing()
    run = pa10d.Run(t, q, tau, temperature=tau, extra={"load": t})
    for array in (run.time, run.q, run.tau, run.temperature, run.extra["load"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    q[:] = 7.0
    assert run.q.max() <= 1.0, "the caller's array is not the run's"


def test_a_repr_of_one_line():
    run = pa10d.Run(*swing(), name="train")
    assert repr(run) == "<Run train: 3.99 s at 100 Hz, 2 joints>"


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda t, q, tau: (t[::-1], q, tau), "never fall"),
        (lambda t, q, tau: (t[:50], q[:50], tau[:50]), "at least 100"),
        (lambda t, q, tau: (t, q[:-1], tau), r"q: found shape \(399, 2\), expected \(400, 2\)"),
        (lambda t, q, tau: (t, q, tau[:, :1]), "tau: found shape"),
        (lambda t, q, tau: (t, np.where(q == q[7], np.nan, q), tau), "q: joint 1 is nan"),
        (lambda t, q, tau: (t, q, 1e300 * tau), r"tau: joint 1 is .*e\+29"),
        (lambda t, q, tau: (t, q, 1e-300 * tau), "joint 1 is .*e-300 N·m at most"),
        (lambda t, q, tau: (1e-300 * t, q, tau), "steps of 1e-302 s, expected seconds"),
    ],
)
def test_what_cannot_be_a_run_is_one_line(change, says):
    with pytest.raises(pa10d.UserError, match=says) as caught:
        pa10d.Run(*change(*swing()))
    assert "\n" not in str(caught.value)


@given(st.integers(1, 4), st.integers(0, 2**31))
def test_a_run_read_twice_is_the_same(joints, seed):
    t, q, tau = swing(seed, joints)
    assert pa10d.Run(t, q, tau) == pa10d.Run(t, q, tau)


def test_irregular_stamps_become_equal_steps():
    t, q, tau = swing()
    late = t + np.where(np.arange(len(t)) % 2, 2e-3, 0.0)
    run = pa10d.Run(late, q, tau)
    assert np.ptp(np.diff(run.time)) < 1e-9


@pytest.mark.long
@pytest.mark.parametrize(
    "before", ["", "import pa10d.compare", "from pa10d.effects import Context", "import pa10d.cli"]
)
def test_the_face_is_the_same_whoever_imported_what_before(before):
    code = f"{before}\nimport pa10d\nassert all(callable(getattr(pa10d, n)) for n in pa10d.__all__)"
    subprocess.run([sys.executable, "-c", code + "\npa10d.effects()"], check=True)


def test_importing_it_loads_nothing_heavy():
    code = "import pa10d, sys; assert not {'numpy', 'scipy', 'pinocchio'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_every_effect_is_listed():
    known = {effect.id: effect for effect in pa10d.effects()}
    assert {"stribeck", "payload", "coulomb", "backlash"} <= set(known)
    assert known["stribeck"].equation in str(known["stribeck"])


def test_help_is_a_page():
    assert "pa10d.diagnose(model" in pa10d.__doc__
    for name in pa10d.__all__:
        assert getattr(pa10d, name).__doc__ or name in ("Cancelled", "UserError"), name


@pytest.mark.parametrize("name", [n for n in pa10d.__all__ if n[0].islower()])
def test_help_with_a_question_says_what_it_takes(name):
    """Half of them are packages that can be called, and help showed the package alone."""
    asked = getattr(pa10d, name)
    takes = inspect.signature(asked)
    page = pydoc.render_doc(asked, renderer=pydoc.plaintext)
    begin = page.partition("PACKAGE CONTENTS")[0]
    assert all(parameter in begin for parameter in takes.parameters), begin
    assert name in (pa10d.__doc__ or "")


def test_help_with_a_value_says_how_it_is_made():
    assert list(inspect.signature(pa10d.Run).parameters)[:3] == ["time", "q", "tau"]


def test_a_recording_in_degrees_is_refused_unless_forced(tmp_path, shared_data):
    source = shared_data / "double_pendulum"
    robot = pa10d.load_robot(source / "robot.urdf")
    good = pa10d.load_run(source / "train1.csv", robot)
    table = np.column_stack([good.time, np.degrees(good.q), good.tau])
    file = tmp_path / "degrees.csv"
    np.savetxt(file, table, delimiter=",", header="time,q1,q2,tau1,tau2", comments="")
    with pytest.raises(pa10d.UserError, match="degrees"):
        pa10d.load_run(file, robot)
    assert any("degrees" in remark for remark in pa10d.load_run(file, robot, force=True).remarks)
    mended = pa10d.load_run(file, robot, map={"q{n}[deg]": "q"}, name=good.name)
    assert np.allclose(mended.q, good.q, atol=1e-6)


def test_what_the_data_leave_open_is_said_as_the_commands_say_it(shared_data):
    source = shared_data / "double_pendulum"
    robot = pa10d.load_robot(source / "robot.urdf")
    model = pa10d.identify(robot, [pa10d.load_run(source / "train1.csv", robot)])
    for index, effect in enumerate(model.effects):
        for parameter, value in zip(
            effect.parameters, model.inner.term_values(index).values(), strict=True
        ):
            assert ("not determined" in str(parameter)) == ("not determined" in str(value))
    assert "not determined" in " ".join(map(str, model.effects)), "this run leaves v0 open"
