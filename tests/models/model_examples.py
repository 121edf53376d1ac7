"""Models with everything in them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pa10d.dynamics import base_parameters, robot_from_urdf
from pa10d.effects import Context, all_effects
from pa10d.model import ModelNotes, Term, TorqueModel
from pa10d.model.notes import TorqueEndNote

LINK = """<link name="l{k}"><inertial><origin xyz="0.02 0.03 0.2"/><mass value="{m}"/>
<inertia ixx="0.2" ixy="0.01" ixz="0" iyy="0.25" iyz="0.02" izz="0.1"/></inertial></link>"""
LINKS = "".join(LINK.format(k=k, m=5 - k) for k in range(1, 5))
URDF = f"""<robot name="four"><link name="l0"/>{LINKS}
<link name="flange"><inertial><origin xyz="0 0 0.05" rpy="0.3 0 0"/><mass value="0.5"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.02"/></inertial></link>
<joint name="j1" type="revolute"><parent link="l0"/><child link="l1"/><origin xyz="0 0 0.3"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="100" velocity="2"/></joint>
<joint name="j2" type="continuous"><parent link="l1"/><child link="l2"/>
<origin xyz="0 0.1 0.3" rpy="1.5707963 0 0"/><axis xyz="0 0.6 0.8"/></joint>
<joint name="j3" type="prismatic"><parent link="l2"/><child link="l3"/>
<origin xyz="0 0 0.2" rpy="0 -1 0.2"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="100" velocity="2"/></joint>
<joint name="j4" type="revolute"><parent link="l3"/><child link="l4"/>
<origin xyz="0.1 0 0.2" rpy="0 0.4 0"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="100" velocity="2"/></joint>
<joint name="mount" type="fixed"><parent link="l4"/><child link="flange"/>
<origin xyz="0 0.1 0.1" rpy="0 0 0.5"/></joint></robot>"""
ROBOT = robot_from_urdf(URDF)
SIZES = {"rotor_inertia": 0.3, "coulomb": 2.0, "viscous": 1.5}


def textbook(name: str = "m0", robot=ROBOT, **more) -> TorqueModel:
    """Random but reproducible numbers everywhere, so that nothing is equal by accident."""
    rng = np.random.default_rng(7)
    base = base_parameters(robot)
    terms = tuple(
        Term(
            kind,
            (j,),
            np.array([size * rng.uniform(0.5, 1.5)]),
            {"v0": float(rng.uniform(0.01, 0.05))} if kind == "coulomb" else {},
            {"v0": 1e-3} if kind == "coulomb" else {},
        )
        for kind, size in SIZES.items()
        for j in range(robot.n)
    )
    terms += more.pop("terms", ())
    size = len(base) + sum(len(term.coefficients) for term in terms)
    root = rng.normal(0, 0.01, (size, size))
    return TorqueModel(
        name=name,
        robot=robot,
        base=base,
        h=base.of(robot.parameters) * rng.uniform(0.9, 1.1, len(base)),
        terms=terms,
        covariance=root @ root.T,
        noise=rng.uniform(0.1, 1, robot.n),
        cutoff=9.5,
        shift=1.25e-3,
        standard=robot.parameters.copy(),
        feasible=True,
        runs=("train a", "train b"),
        held_out={"valid": rng.uniform(0.1, 1, robot.n)},
        notes=ModelNotes(
            noise_floor=tuple(rng.uniform(0.1, 1, robot.n).tolist()),
            warnings=("one", "two"),
            torque_ends=(TorqueEndNote(robot.n, -1.5, largest=False),),
        ),
        **more,
    )


def some_term(effect_id: str, seed: int = 0) -> Term:
    """An effect with random coefficients and a shape within its bounds."""
    rng = np.random.default_rng(seed)
    kind = all_effects()[effect_id]
    joints = {"joint": (1,), "pair": (1, 3), "robot": ()}[kind.scope]
    shape = {}
    for s in kind.shapes:
        shape[s.name] = float(
            np.sqrt(s.lower * s.upper) if s.scale == "log" else 0.5 * (max(s.lower, 1.0) + s.upper)
        )
    shape.pop("elsewhere", None)  # with it the effect has no torque
    if "rotor" in shape:
        shape["rotor"] = 50.0
    if effect_id == "contact":
        shape = {"qs": 0.2, "side": -1.0}
    if effect_id == "torque_ripple":
        shape = {"N": 31.5}
    if effect_id == "position_friction":
        shape = {"qc": 0.1, "w": 0.2, "wave": float(rng.integers(2))}
    small = rng.uniform(0.05, 0.2, len(kind.coefficients))
    if effect_id == "torque_saturation":
        small *= 1e-4
    return Term(effect_id, joints, small, shape)


def motion(robot=ROBOT, samples: int = 400, dt: float = 0.004) -> Context:
    """Sums of sines with many reversals."""
    rng = np.random.default_rng(3)
    t = np.arange(samples) * dt
    omega, phase = rng.uniform(1, 9, (2, robot.n, 3))
    angle = omega[None] * t[:, None, None] + phase[None]
    size = 0.3 / omega
    return Context(
        robot=robot,
        t=t,
        q=np.sum(size * np.sin(angle), axis=2),
        dq=np.sum(size * omega * np.cos(angle), axis=2),
        ddq=np.sum(-size * omega**2 * np.sin(angle), axis=2),
        rigid=np.zeros((robot.n, 10)),
        total=np.zeros((samples, robot.n)),
    )


def with_effects(model: TorqueModel, *ids: str, name: str = "m1") -> TorqueModel:
    """The model with further effects."""
    new = tuple(some_term(effect_id) for effect_id in ids)
    size = len(model.covariance) + sum(len(term.coefficients) for term in new)
    covariance = np.eye(size) * 1e-4
    covariance[: len(model.covariance), : len(model.covariance)] = model.covariance
    return replace(
        model,
        name=name,
        terms=(*model.terms, *new),
        covariance=covariance,
        parent=model.name,
        change=" ".join(f"+ {term.label}" for term in new),
    )
