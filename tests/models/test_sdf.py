"""SDF against what it stands for: told again as a URDF, it is the same arm."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import model_examples as examples
import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.dynamics import inverse_dynamics, robot_from_urdf
from pa10d.export.formats import export
from pa10d.export.rotors import rotors_in_bodies


def as_urdf(text):
    """Joint by joint: SDF's frames are links' (their joints stand in them), URDF's are joints'."""
    arm = ET.fromstring(text).find("model")
    links = {link.get("name"): link for link in arm.findall("link")}
    lines = ['<robot name="again"><link name="world"/>']
    for joint in arm.findall("joint"):
        child, parent = joint.findtext("child"), joint.findtext("parent")
        link, axis = links[child], joint.find("axis")
        assert link.find("pose").get("relative_to", "world") == parent
        x, y, z, *rpy = link.findtext("pose").split()
        cx, cy, cz, *turned = link.findtext("inertial/pose").split()
        assert turned == ["0.0"] * 3
        inertia = " ".join(f'{e.tag}="{e.text}"' for e in link.find("inertial/inertia"))
        limits = " ".join(f'{e.tag}="{e.text}"' for e in axis.find("limit"))
        lines.append(
            f'<joint name="{joint.get("name")}" type="{joint.get("type")}">'
            f'<parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{x} {y} {z}" rpy="{" ".join(rpy)}"/><axis xyz="{axis.findtext("xyz")}"/>'
            f'<limit lower="-9" upper="9" effort="1" velocity="1"/><!-- {limits} --></joint>'
            f'<link name="{child}"><inertial><origin xyz="{cx} {cy} {cz}"/>'
            f'<mass value="{link.findtext("inertial/mass")}"/><inertia {inertia}/></inertial>'
            "</link>"
        )
    return "\n".join([*lines, "</robot>"])


def test_it_is_the_same_arm():
    rng = np.random.default_rng(2)
    model = examples.textbook()
    model = replace(model, standard=model.standard * rng.uniform(1.0, 1.2, (4, 1)))
    again = robot_from_urdf(as_urdf(export(model, "sdf").text))
    assert again.joint_names == model.robot.joint_names
    q, dq, ddq = rng.uniform(-1, 1, (3, 30, 4))
    expected = inverse_dynamics(model.robot, rotors_in_bodies(model).standard, q, dq, ddq)
    found = inverse_dynamics(again, again.parameters, q, dq, ddq)
    assert found == pytest.approx(expected, abs=1e-9)


def test_friction_and_limits_stand_in_it_and_the_rest_is_told():
    model = examples.textbook()
    made = export(model, "sdf", motions={"held": examples.motion()})
    joints = {j.get("name"): j for j in ET.fromstring(made.text).iter("joint")}
    found = {t.label: float(t.coefficients[0]) for t in model.possible().terms}
    assert float(joints["j3"].findtext("axis/dynamics/damping")) == found["viscous J3"]
    assert float(joints["j3"].findtext("axis/dynamics/friction")) == found["coulomb J3"]
    assert joints["j1"].findtext("axis/limit/effort") == "100.0"
    assert joints["j2"].find("axis/limit/lower") is None
    assert made.not_carried[0].startswith("rotor_inertia of joints 2, 3, 4 not in the export")
    assert made.loss.rms.min() > 0.0
    assert "gravity, which is the world's: 0.0 0.0 -9.81" in made.text
    with pytest.raises(UserError, match="base parameters of a free fit alone do not make"):
        export(model, "sdf", "free")
