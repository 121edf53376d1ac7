"""The C header against what it stands for: compiled and replayed."""

import ctypes
import re
import shutil
import subprocess

import model_examples as examples
import numpy as np
import pytest

from pa10d.dynamics import inverse_dynamics, robot_from_urdf
from pa10d.effects import all_effects
from pa10d.export.c_header import c_header
from pa10d.export.formats import export
from pa10d.export.trace import NotTraceable, apply, derivatives, in_order, inputs, traced

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc on this machine")
STRICT = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-O1", "-shared", "-fPIC"]
D = ctypes.POINTER(ctypes.c_double)


def compiled(text, folder):
    """torque(q, dq, ddq) and gravity(q), one sample at a time."""
    name = re.search(r"void (\w+)_torque", text)[1]
    (folder / "arm.h").write_text(text, encoding="utf-8")
    (folder / "arm.c").write_text(
        f'#include "arm.h"\n#include "arm.h"\n'
        "void torque(const double *q, const double *dq, const double *ddq, double *tau);\n"
        "void gravity(const double *q, double *tau);\n"
        "void torque(const double *q, const double *dq, const double *ddq, double *tau)\n"
        f"{{ {name}_torque(q, dq, ddq, tau); }}\n"
        f"void gravity(const double *q, double *tau) {{ {name}_gravity(q, tau); }}\n"
    )
    library = folder / "arm.so"
    subprocess.run(["gcc", *STRICT, "-o", library, folder / "arm.c", "-lm"], check=True)
    code = ctypes.CDLL(str(library))

    def call(function, *rows):
        tau = np.full(rows[0].shape, np.nan)
        for k in range(len(tau)):
            given = [np.ascontiguousarray(x[k]) for x in (*rows, tau)]
            function(*(x.ctypes.data_as(D) for x in given))
            tau[k] = given[-1]
        return tau

    return lambda *rows: call(code.torque, *rows), lambda *rows: call(code.gravity, *rows)


@pytest.mark.by_default("coulomb", "joint_elasticity")  # all of them at once below
@pytest.mark.parametrize("effect_id", sorted(all_effects()))
def test_every_effect_agrees_when_compiled(effect_id, tmp_path):
    model, motion = examples.with_effects(examples.textbook(), effect_id), examples.motion()
    text, lost = c_header(model, "test")
    assert lost == []
    torque, _ = compiled(text, tmp_path)
    given = [x[::7] for x in (motion.q, motion.dq, motion.ddq)]
    assert torque(*given) == pytest.approx(model.torque(*given), abs=1e-10)
    kind = all_effects()[effect_id]
    assert (f"{effect_id} of joint" in text or f"{effect_id} remembers" in text) == bool(
        kind.remembers
    )


def test_all_effects_together_agree_and_so_does_gravity(tmp_path):
    model = examples.with_effects(examples.textbook(), *sorted(all_effects()))
    motion = examples.motion()
    made = export(model, "c", "free", "all */ of them")
    torque, gravity = compiled(made.text, tmp_path)
    given = [x[::11] for x in (motion.q, motion.dq, motion.ddq)]
    assert torque(*given) == pytest.approx(model.torque(*given), abs=1e-9)
    rest = np.zeros_like(given[0])
    expected = inverse_dynamics(model.robot, model.rigid, given[0], rest, rest)
    assert gravity(given[0]) == pytest.approx(expected, abs=1e-10)
    assert "malloc" not in made.text


LIFT = """<robot name="lift"><link name="base"/><link name="l"><inertial><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="up" type="prismatic"><parent link="base"/><child link="l"/><axis xyz="0 0 1"/>
<limit lower="0" upper="1" effort="9" velocity="1"/></joint></robot>"""


def test_a_weight_that_is_the_same_everywhere_compiles_without_a_warning(tmp_path):
    model = examples.textbook(robot=robot_from_urdf(LIFT))
    torque, gravity = compiled(c_header(model, "test")[0], tmp_path)
    q, dq, ddq = np.random.default_rng(1).uniform(-1, 1, (3, 5, 1))
    assert torque(q, dq, ddq) == pytest.approx(model.torque(q, dq, ddq), abs=1e-10)
    assert gravity(q) == pytest.approx(np.full((5, 1), 2 * 9.81), rel=0.11)  # of a fitted mass


@pytest.mark.long
def test_what_cannot_be_written_down_is_said():
    from pa10d.effects.smooth_map import smooth_map
    from pa10d.model import Term

    kind = smooth_map(("q2",))
    shape = {"q2 from": -1.0, "q2 to": 1.0, "smoothing": 1.0}
    term = Term("smooth_map", (1,), np.ones(len(kind.coefficients)), shape, over=("q2",))
    text, lost = c_header(examples.textbook(terms=(term,)), "test")
    assert lost == [
        "smooth_map of joint 2 not in the export: a map of what nobody understands stays where its "
        "range is watched"
    ]
    assert "NOT CARRIED: smooth_map of joint 2" in text
    with pytest.raises(NotTraceable, match="a decision that depends on the motion"):
        max(inputs("q", 1)[0, 0], 0.0)
    with pytest.raises(NotTraceable, match="the function logaddexp"):
        np.logaddexp(inputs("q", 1), 0.0)


def test_what_is_known_is_carried_out_and_equal_things_are_one():
    q = inputs("q", 2)
    assert list((0.0 * q + 3.0)[0]) == [3.0, 3.0]
    assert (1.0 * q)[0, 0] is q[0, 0]
    twice = np.sin(q) * np.sin(1.0 * q)
    assert [node.op for node in in_order(twice[0, :1])] == ["input", "sin", "multiply"]
    assert apply("where", 1.0, q[0, 0], 2.0) is q[0, 0]
    (slope,) = derivatives([np.cos(q)[0, 1] * q[0, 0]], q[0, 1])
    assert [node.op for node in in_order([slope])][-1] == "multiply"
    assert traced([1.0, 2.0]).sum() == 3.0
