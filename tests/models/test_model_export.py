"""Exports against what they stand for: Pinocchio for the URDF, the model for the module."""

import json
import subprocess
import sys

import model_examples as examples
import numpy as np
import pytest

from pa10d.common.errors import UserError
from pa10d.effect_kit import draws
from pa10d.effects import all_effects
from pa10d.export.formats import export
from pa10d.export.python_module import python_module
from pa10d.export.sdf import sdf
from pa10d.export.urdf import urdf_with_inertia
from pa10d.model.impossible import impossible, mass_matrices
from pa10d.model.notes import FeasibleNote

DRAWS = 200


def module(model):
    text, lost = python_module(model, "test")
    space: dict = {}
    exec(compile(text, "exported", "exec"), space)
    return space, lost


def test_textbook_model_and_module_agree_along_a_motion():
    model, motion = examples.textbook(), examples.motion()
    space, lost = module(model)
    assert lost == []
    found = space["torque_series"](motion.q, motion.dq, motion.ddq)
    assert found == pytest.approx(model.predict(motion), abs=1e-10)


@pytest.mark.by_default(
    "backlash",
    "coulomb",
    "joint_elasticity",
    "payload",
    "stribeck",
    "thermal_friction",
    "torque_delay",
    "torque_gain",
    "presliding_hysteresis",
)
@pytest.mark.parametrize("effect_id", sorted(all_effects()))
def test_every_effect_agrees(effect_id):
    model = examples.with_effects(examples.textbook(), effect_id)
    motion = examples.motion()
    space, lost = module(model)
    assert lost == []
    found = space["torque"](motion.q, motion.dq, motion.ddq, motion.t)
    expected = model.torque(motion.q, motion.dq, motion.ddq, motion.t)
    assert expected == pytest.approx(model.predict(motion), abs=1e-12)
    assert np.max(np.abs(expected - examples.textbook().predict(motion))) > 1e-6
    assert found == pytest.approx(expected, abs=1e-9)
    apart = space["torque"](motion.q, motion.dq, motion.ddq)
    assert apart == pytest.approx(model.torque(motion.q, motion.dq, motion.ddq), abs=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("effect_id", sorted(all_effects()))
def test_every_effect_agrees_over_random_shapes_and_motions(effect_id):
    """Wherever it sits, whatever its shape, along a motion and apart: the class's own formula."""
    from dataclasses import replace

    rng, kind = np.random.default_rng(sum(effect_id.encode())), all_effects()[effect_id]
    book = examples.textbook()
    book = replace(book, terms=tuple(t for t in book.terms if t.joints == (1,)))
    space = module(replace(book, terms=(*book.terms, examples.some_term(effect_id))))[0]
    worst = 0.0
    for _ in range(DRAWS):
        path = draws.path(rng, examples.ROBOT, int(rng.integers(2, 12)))
        term = draws.term(rng, kind, draws.context(examples.ROBOT, path))
        model = replace(book, terms=(*book.terms, term))
        same = type(space["TERMS"][-1].effect)()
        space["TERMS"][-1] = space["Term"](same, term.joints, term.coefficients, term.shape)
        for time in (path.t, None):
            expected = model.torque(path.q, path.dq, path.ddq, time)
            found = space["torque"](path.q, path.dq, path.ddq, time)
            size = max(1.0, float(np.max(np.abs(expected))))
            worst = max(worst, float(np.max(np.abs(found - expected))) / size)
    assert worst < 1e-9


def test_the_module_needs_no_place_among_the_loaded_ones(tmp_path):
    """``dataclass`` looks up annotations in ``sys.modules``, where nobody has to put a module."""
    import ast
    import importlib.util

    motion, model = examples.motion(), examples.with_effects(
        examples.textbook(), *sorted(all_effects())
    )  # fmt: skip
    file = tmp_path / "nobodys_module.py"
    file.write_text(python_module(model, "test")[0])
    told = importlib.util.spec_from_file_location(file.stem, file)
    assert told is not None
    assert told.loader is not None
    loaded = importlib.util.module_from_spec(told)
    told.loader.exec_module(loaded)
    assert file.stem not in sys.modules
    found, true = loaded.torque(motion.q, motion.dq, motion.ddq, motion.t), model.predict(motion)
    # to ten digits: effects that differentiate torque make more of how each of both is rounded
    assert found == pytest.approx(true, abs=1e-10 * np.abs(true).max())
    tree = ast.parse(file.read_text())
    typed = [n for n in ast.walk(tree) if isinstance(n, ast.arg) and n.annotation]
    typed += [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef) and n.returns]
    assert typed == [], "types that the module does not have"


def test_a_wide_stribeck_joint_agrees():
    """Its sign once had another width in the export from vs = 0.2 rad/s on: 1.7 to 6 N·m."""
    from dataclasses import replace

    motion, term = examples.motion(), examples.some_term("stribeck")
    wide = replace(term, coefficients=np.array([8.0]), shape={"vs": 0.6, "delta": 1.0})
    model = examples.textbook(terms=(wide,))
    found = module(model)[0]["torque_series"](motion.q, motion.dq, motion.ddq)
    assert found == pytest.approx(model.predict(motion), abs=1e-9)


def test_loads_of_their_own_and_signs_of_one_name_agree():
    """A model that takes its loads from other parameters, and constants that share a name."""
    from dataclasses import replace

    motion = examples.motion()
    model = examples.with_effects(
        examples.textbook(), "load_friction", "stribeck", "coupling_friction", "encoder_offset"
    )
    model = replace(model, loads=1.2 * model.h)
    found = module(model)[0]["torque_series"](motion.q, motion.dq, motion.ddq)
    assert found == pytest.approx(model.predict(motion), abs=1e-9)
    assert np.max(np.abs(found - replace(model, loads=None).predict(motion))) > 1e-3


def test_linearised_offsets_agree():
    from dataclasses import replace

    motion = examples.motion()
    for effect_id, shape in (
        ("encoder_offset", {"at": 0.05}),
        ("base_tilt", {"rx": 0.1, "ry": -0.2}),
    ):
        model = examples.textbook(terms=(replace(examples.some_term(effect_id), shape=shape),))
        found = module(model)[0]["torque_series"](motion.q, motion.dq, motion.ddq)
        assert found == pytest.approx(model.predict(motion), abs=1e-8)


def test_without_a_series_the_sign_is_that_of_the_sample():
    model, motion = examples.textbook(), examples.motion()
    space, _ = module(model)
    apart = space["torque"](motion.q, motion.dq, motion.ddq)
    one = space["torque"](motion.q[7], motion.dq[7], motion.ddq[7])
    assert one.shape == (4,)
    assert one == pytest.approx(apart[7], abs=1e-12)
    coulomb = [t for t in model.terms if t.effect_id == "coulomb"]
    averaged = model.predict(motion)
    for term in coulomb:
        j, v0, size = term.joints[0], term.shape["v0"], term.coefficients[0]
        from pa10d.effects import smooth_sign

        averaged[:, j] += size * (np.tanh(motion.dq[:, j] / v0) - smooth_sign(motion.dq[:, j], v0))
    assert apart == pytest.approx(averaged, abs=1e-10)


def test_what_remembers_wants_to_know_the_time():
    space, _ = module(examples.with_effects(examples.textbook(), "backlash"))
    motion = examples.motion()
    with pytest.raises(ValueError, match=r"^dt: expected the seconds between rows for backlash"):
        space["torque_series"](motion.q, motion.dq, motion.ddq)
    assert "backlash remembers how far the link lags behind" in space["__doc__"]


def test_what_is_not_carried_is_said():
    """A map stays where its range is watched; the reason is of the thing, not of a list."""
    from pa10d.effects.smooth_map import smooth_map
    from pa10d.model import Term

    kind = smooth_map(("q2",))
    shape = {"q2 from": -1.0, "q2 to": 1.0, "smoothing": 1.0}
    term = Term("smooth_map", (1,), np.ones(len(kind.coefficients)), shape, over=("q2",))
    model = examples.textbook(terms=(term,))
    space, lost = module(model)
    assert lost == [
        "smooth_map of joint 2 not in the export: a map of what nobody understands stays where its "
        "range is watched"
    ]
    assert "NOT CARRIED: smooth_map of joint 2" in space["__doc__"]
    assert space["NOT_CARRIED"] == [term.label]


def test_the_module_stands_on_numpy_alone(tmp_path):
    model = examples.with_effects(examples.textbook(), *sorted(all_effects()))
    (tmp_path / "arm.py").write_text(python_module(model, "test")[0])
    script = (
        "import sys, numpy as np, arm\n"
        "print(arm.torque(np.zeros(4), np.zeros(4), np.zeros(4)).shape)\n"
        "print(sorted(m for m in sys.modules if m.split('.')[0] in ('pa10d', 'scipy', 'numba')))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.split("\n")[:2] == ["(4,)", "[]"]


def test_urdf_gives_the_models_torques_in_pinocchio(tmp_path):
    import pinocchio as pin

    rng = np.random.default_rng(5)
    model = examples.textbook()
    standard = model.standard * rng.uniform(1.0, 1.2, (4, 1))
    from dataclasses import replace

    text, _ = urdf_with_inertia(replace(model, standard=standard), "test -- twice")
    (tmp_path / "arm.urdf").write_text(text)
    arm = pin.buildModelFromUrdf(str(tmp_path / "arm.urdf"))
    data = arm.createData()
    from pa10d.dynamics import inverse_dynamics

    q, dq, ddq = rng.uniform(-1, 1, (3, 20, 4))
    expected = inverse_dynamics(examples.ROBOT, standard, q, dq, ddq)
    for k in range(20):
        # joint 2 turns for ever: Pinocchio wants its cosine and sine
        state = np.array([q[k, 0], np.cos(q[k, 1]), np.sin(q[k, 1]), q[k, 2], q[k, 3]])
        assert pin.rnea(arm, data, state, dq[k], ddq[k]) == pytest.approx(expected[k], abs=1e-10)


def test_urdf_keeps_friction_and_says_what_it_cannot():
    import xml.etree.ElementTree as ET

    model = examples.with_effects(examples.textbook(), "stribeck")
    text, lost = urdf_with_inertia(model, "test")
    joints = {joint.get("name"): joint for joint in ET.fromstring(text).findall("joint")}
    viscous = next(t for t in model.terms if t.effect_id == "viscous" and t.joints == (1,))
    assert float(joints["j2"].find("dynamics").get("damping")) == viscous.coefficients[0]
    assert joints["j2"].get("type") == "continuous"
    assert [line.split(" not in ")[0] for line in lost] == [
        "rotor_inertia of joints 1, 2, 3, 4",
        "stribeck of joint 2",
    ]


def test_friction_of_bristles_is_the_dry_friction_of_a_urdf():
    """What dry friction is told as where all of it builds up over a way, no data determine."""
    import xml.etree.ElementTree as ET
    from dataclasses import replace

    model = examples.with_effects(examples.textbook(), "presliding_hysteresis")
    (bristles,) = (t for t in model.terms if t.effect_id == "presliding_hysteresis")
    (j,) = bristles.joints

    def elsewhere(term):
        if term.effect_id != "coulomb" or term.joints != (j,):
            return term
        shape = {**term.shape, "elsewhere": 1.0}
        return replace(term, coefficients=np.array([1130.0]), shape=shape)

    model = replace(model, terms=tuple(map(elsewhere, model.terms)))
    for text, place in (
        (urdf_with_inertia(model, "test")[0], "friction"),
        (sdf(model, "test")[0], ""),
    ):
        found = ET.fromstring(text.encode()).findall(".//joint")[j].find(".//dynamics")
        written = found.get(place) if place else found.find("friction").text
        assert float(written) == bristles.coefficients[0]


def bounded(model, **lowest):
    """With a feasible set whose coefficients are 0.5, or as given."""
    from dataclasses import replace

    names = model.parameter_names()[len(model.h) :]
    found = dict.fromkeys(names, 0.5) | {key.replace("_", " "): v for key, v in lowest.items()}
    return replace(model, notes=replace(model.notes, feasible=FeasibleNote((1.0,) * 4, found)))


def test_friction_in_a_urdf_is_the_feasible_sets():
    """The free fit may have it negative; a simulator would gain energy from that."""
    import xml.etree.ElementTree as ET

    made = export(bounded(examples.textbook()), "urdf")
    assert made.parameters == "feasible"
    assert "feasible parameters" in made.text
    joints = {joint.get("name"): joint for joint in ET.fromstring(made.text).findall("joint")}
    assert joints["j2"].find("dynamics").attrib == {"damping": "0.5", "friction": "0.5"}


def test_the_module_carries_bodies_that_can_exist_unless_asked_otherwise():
    model, motion = bounded(examples.textbook()), examples.motion()
    given = (motion.q, motion.dq, motion.ddq, motion.t)
    found = {}
    for parameters in ("feasible", "free"):
        space: dict = {}
        made = export(model, "python", parameters, "m0 (abc)")
        exec(compile(made.text, "exported", "exec"), space)
        found[parameters] = space["torque"](*given)
        assert found[parameters] == pytest.approx(model.torque(*given, parameters), abs=1e-9)
        assert f"m0 (abc); {parameters} parameters" in " ".join(space["__doc__"].split())
    assert np.max(np.abs(found["free"] - found["feasible"])) > 0.1
    assert export(model, "python").text == export(model, "python", "feasible").text


def test_a_free_fit_that_cannot_exist_is_said_in_words():
    from dataclasses import replace

    model = examples.textbook()
    assert impossible(model.possible()) == ()
    light = replace(model, h=-model.h)
    light = replace(
        light,
        terms=tuple(
            replace(t, coefficients=-t.coefficients) if t.label == "rotor_inertia J4" else t
            for t in light.terms
        ),
    )
    said = export(light, "python", "free").warnings
    assert "mass matrix is not positive definite in" in said[0]
    assert "--parameters feasible" in said[0]
    assert any(s.startswith("rotor_inertia J4: Ia = -0.2") and "at least 0" in s for s in said)
    assert export(light, "python", "feasible").warnings == ()


def test_mass_matrices_are_those_of_pinocchio():
    """With the rotors on the diagonal."""
    model = examples.textbook().possible()
    from pa10d.dynamics.typical import usual_poses

    pin = pytest.importorskip("pinocchio")
    arm, index = model.robot.pinocchio()
    data = arm.createData()
    rotors = {t.joints[0]: t.coefficients[0] for t in model.terms if t.effect.is_rotor}
    for q, found in list(zip(usual_poses(model.robot), mass_matrices(model), strict=True))[:5]:
        state = pin.neutral(arm)
        angles = q[index]
        state = pin.integrate(arm, state, angles)
        expected = pin.crba(arm, data, state)
        expected = np.triu(expected) + np.triu(expected, 1).T
        back = np.argsort(index)
        expected = expected[np.ix_(back, back)] + np.diag([rotors[j] for j in range(4)])
        assert found == pytest.approx(expected, abs=1e-9)


def test_what_cannot_be_written_so_is_said():
    from dataclasses import replace

    model = examples.textbook()
    with pytest.raises(UserError, match="base parameters of a free fit alone do not make"):
        export(model, "urdf", "free")
    with pytest.raises(UserError, match=r"no feasible standard parameters; .* --parameters free"):
        export(replace(model, standard=None), "python")
    with pytest.raises(UserError, match="no feasible standard parameters") as told:
        export(replace(model, standard=None), "urdf")
    assert "--parameters free" not in str(told.value)


def test_the_possible_model_stands_on_the_feasible_bodies():
    from dataclasses import replace

    model = examples.textbook()
    possible = model.possible()
    assert possible.h == pytest.approx(model.base.of(model.standard), abs=1e-14)
    assert [t.label for t in possible.terms] == [t.label for t in model.terms]
    with pytest.raises(UserError, match="no feasible standard parameters"):
        replace(model, standard=None).possible()


def test_urdf_needs_feasible_parameters():
    from dataclasses import replace

    with pytest.raises(UserError, match="no feasible standard parameters"):
        urdf_with_inertia(replace(examples.textbook(), standard=None), "test")


def test_json_is_the_whole_model():
    """Rebuilt from the document alone it predicts the same."""
    from dataclasses import replace

    from pa10d.dynamics import base_parameters, robot_from_urdf
    from pa10d.model import Term, TorqueModel

    model = examples.with_effects(examples.textbook(), "stribeck", "payload", "backlash")
    model = replace(model, loads=1.1 * model.h)
    told = json.loads(export(model, "json", "free", "m1 (abc)").text)
    assert told["schema"] == "pa10d/model/1"
    assert told["about"].startswith("m1 (abc); free parameters")
    robot = robot_from_urdf(told["robot"]["urdf"], told["robot"]["joints"])
    base = base_parameters(robot)
    names = [p["name"] for p in told["base_parameters"]]
    assert names == [told["covariance"]["of"][k] for k in range(len(names))]
    terms = tuple(
        Term(
            e["effect"],
            tuple(j - 1 for j in e["joints"]),
            np.array([c["value"] for c in e["coefficients"].values()]),
            {name: s["value"] for name, s in e["shape"].items()},
        )
        for e in told["effects"]
    )
    bodies = [list(b.values())[1:] for b in told["bodies_for_loads"]]
    again = TorqueModel(
        told["name"], robot, base, np.array([p["value"] for p in told["base_parameters"]]), terms,
        np.array(told["covariance"]["rows"]), np.array(told["fit"]["rms"]),
        told["fit"]["cutoff_hz"], loads=base.of(np.array(bodies)),
    )  # fmt: skip
    motion = examples.motion()
    assert again.predict(motion) == pytest.approx(model.predict(motion), abs=1e-10)
    assert again.std_errors == pytest.approx(model.std_errors)
    assert told["effects"][-1]["remembers"].startswith("how far the link lags")
    assert told["robot"]["lower"][1] is None
    row = told["base_parameters"][3]["of_standard"]
    standard = {
        f"{name}{j + 1}": value
        for j, body in enumerate(told["bodies"])
        for name, value in list(body.items())[1:]
    }
    assert sum(standard[k] * v for k, v in row.items()) == pytest.approx(
        told["base_parameters"][3]["value"]
    )
