"""The conformance kit: the library passes, and every kind of fault has a check that tells it."""

import importlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from test_third_party import CLASS, installed  # noqa: F401

from pa10d.common.errors import UserError
from pa10d.dynamics import robot_from_profile
from pa10d.effect_kit import carried as carried_module
from pa10d.effect_kit import check, draws
from pa10d.effect_kit.carried import carried
from pa10d.effect_kit.dimension import power_of_second
from pa10d.effect_kit.scaffold import scaffold
from pa10d.effects import all_effects, effect
from pa10d.export.python_module import python_module
from pa10d.profile import load_profile


@pytest.mark.by_default(
    "backlash",
    "coulomb",
    "payload",
    "spring",
    "stribeck",
    "torque_gain",
    "thermal_friction",
    "presliding_hysteresis",
)
@pytest.mark.parametrize("name", sorted(all_effects()))
def test_the_library_conforms(name):
    assert [v for v in check(effect(name), draws=3) if not v.passed] == []


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(all_effects()))
def test_the_library_is_exported_as_it_is(name):
    """Over 200 random shapes and motions of seven joints."""
    robot = robot_from_profile(load_profile("pa10-sim"))
    assert carried(effect(name), robot, np.random.default_rng(7), 200) is None


def test_a_rotor_is_drawn_as_a_part_of_what_its_joint_moves():
    """One rounding of an angle moved the answer of a heavier one by 1e-5 N·m."""
    rng, robot = np.random.default_rng(7), robot_from_profile(load_profile("pa10-sim"))
    kind = effect("joint_elasticity")
    for j in range(robot.n):
        seen = draws.context(robot, draws.path(rng, robot, 5))
        drawn = draws.shape(rng, kind, seen, (j,), whole=True)["rotor"]
        assert 0.0 < drawn < seen.inertia_seen(j).min()


@pytest.mark.long
@pytest.mark.parametrize("name", ["spring", "stribeck"])
def test_what_is_hidden_is_found_again(name):
    assert [v for v in check(effect(name), draws=1, hide=True) if not v.passed] == []


def test_the_guides_effect_conforms_and_is_exported(installed):  # noqa: F811
    installed()
    found = check(effect("creeping_hose"), draws=8)
    assert [v for v in found if not v.passed] == []
    assert found[-1].check == "export"


@pytest.mark.long
def test_the_guides_effect_is_exported_as_it_is(installed, monkeypatch):  # noqa: F811
    """Over 200 random shapes and motions; and a law that became another since is told."""
    installed()
    kind, robot = effect("creeping_hose"), robot_from_profile(load_profile("pa10-sim"))
    assert carried(kind, robot, np.random.default_rng(7), 200) is None
    columns = type(kind).columns

    def other(self, *asked):
        return columns(self, *asked) * (1.0 + 1e-6)

    written = python_module
    monkeypatch.setattr(
        carried_module, "python_module", lambda *asked: (written(*asked), change())[0]
    )

    def change():
        monkeypatch.setattr(type(kind), "columns", other)

    assert "off by" in (carried(kind, robot, np.random.default_rng(7), 5) or "")


@pytest.mark.long
def test_the_guides_effect_is_found_again(installed):  # noqa: F811
    installed()
    assert [v for v in check(effect("creeping_hose"), 1, hide=True) if not v.passed] == []


RETURN = "        return stretch[:, None]\n"


@pytest.mark.parametrize(
    ("old", "new", "name", "message"),
    [
        ("    example =", "    other =", "whole", "'example' is missing"),
        (RETURN, "        return stretch\n", "columns", "shape (120,), expected (120, 1)"),
        (RETURN, "        return stretch[:, None] / 0.0\n", "columns", "not finite"),
        (
            RETURN,
            "        self.n = getattr(self, 'n', 0) + 1\n        return self.n * q[:, None]\n",
            "columns",
            "a second call gives other columns",
        ),
        (RETURN, "        context.q[0] += 1\n" + RETURN, "columns", "change the run"),
        (RETURN, "        return stretch[::-1, None]\n", "causality", "depend on later ones"),
        ('{"T": seconds}', '{"tau": seconds}', "starts", "expected values for ['T']"),
        ("(0.5, 2.0, 10.0)", "(500.0,)", "starts", "T = 500, outside its bounds"),
        ("stretch[:, None]", "stretch[:, None] * context.load[:, :1]", "model", "uses_model"),
        ('"N·m/rad", lower', '"N·m·s/rad", lower', "units", "expected 2^-1.00"),
        ('"N·m/rad", lower', '"furlong", lower', "units", "'furlong' is not known"),
        ("context.dt / shape", "context.dt / 2.0 + 0 * shape", "derivative", "T changes nothing"),
        (
            "        if context.apart:\n            return np.zeros((len(context.q), 1))\n",
            "",
            "prediction",
            "IndexError",
        ),
        ('View("q"', 'View("angle"', "roles", "'view' is against 'angle', expected one of q, dq"),
        ('{"spring"', '{"sprung"', "roles", "'confounders' names 'sprung'"),
        ("    view =", '    line_order = "N"\n    view =', "roles", "no shape parameter"),
        ("    view =", "    live = True\n    view =", "roles", "may use dq and ddq only"),
        ('"point_to_point"', '"wiggle"', "roles", "'experiment_kind' is 'wiggle'"),
        (
            "fading(moved, kept)",
            "__import__('math').exp(0) * lfilter([1.0], [1.0, -kept], moved)",
            "export",
            "its formula uses scipy, and an export stands on NumPy alone",
        ),
    ],
)  # fmt: skip
def test_every_fault_is_told_by_its_check(installed, old, new, name, message):  # noqa: F811
    code = CLASS.replace(
        "import numpy as np\n", "import numpy as np\nfrom scipy.signal import lfilter\n"
    )
    assert old in code
    installed(code.replace(old, new, 1))
    wrong = {v.check: v.says for v in check(effect("creeping_hose"), draws=3) if not v.passed}
    assert message in wrong[name]


def test_powers_of_the_second():
    told = {"N·m": -2, "N·m·s/rad": -1, "1/(N·m)²": 4, "kg·m²": 0, "N·m·(s/rad)^p": 0.5, "1/W": 3}
    for unit, power in told.items():
        assert power_of_second(unit, {"p": 2.5}) == power, unit
    for unit in ("N·m·", "(N", "ell", "N m"):
        with pytest.raises((ValueError, IndexError)):
            power_of_second(unit, {})


@pytest.mark.long
def test_a_new_package_conforms_as_it_stands(tmp_path, monkeypatch):
    folder = tmp_path / "soft_detent"
    files = scaffold("soft_detent", folder)
    assert {f.relative_to(folder).as_posix() for f in files} == {
        "soft_detent.py", "soft_detent_hidden.py", "soft_detent.md", "pyproject.toml",
        "tests/test_soft_detent.py",
    }  # fmt: skip
    info = folder / "soft_detent-0.1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: soft-detent\nVersion: 0.1.0\n")
    (info / "entry_points.txt").write_text(
        "[pa10d.effects]\nsoft_detent = soft_detent:SoftDetent\n"
        "[pa10d.hidden]\nsoft_detent = soft_detent_hidden:SoftDetentLaw\n"
    )
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests"],
        cwd=folder,
        env={
            "PYTHONPATH": f"{folder}:{Path(__file__).parents[2]}", "PATH": "/usr/bin:/bin",
            "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1",
        },
        capture_output=True,
        text=True,
        timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:]
    importlib.invalidate_caches()


def test_a_name_has_to_be_free_and_a_name(tmp_path):
    with pytest.raises(UserError, match="small letters, digits and underscores"):
        scaffold("Soft-Detent", tmp_path / "x")
    with pytest.raises(UserError, match="there is such an effect already"):
        scaffold("spring", tmp_path / "x")
    with pytest.raises(UserError, match="there is such a file or folder already"):
        scaffold("soft_detent", tmp_path)


def test_the_command_line(tmp_path, capsys, monkeypatch):
    from pa10d.cli import main

    monkeypatch.chdir(tmp_path)
    assert main(["effect", "new", "soft_detent"]) == 0
    assert (tmp_path / "soft_detent" / "soft_detent.py").is_file()
    assert main(["effect", "check", "viscous", "--draws", "2", "--json"]) == 0
    assert '"passed": true' in capsys.readouterr().out
    assert main(["effect", "check", "viscos"]) == 1
    assert "no such effect" in capsys.readouterr().err
    assert main(["effect", "page", "viscous"]) == 0
    assert "# Viscous friction" in capsys.readouterr().out
    assert main(["effect", "list"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 1 + len(np.unique(list(all_effects())))


def test_a_sharpness_that_was_assumed_is_not_determined():
    """Its standard error is 0 because nothing was fitted, and no value stands behind "± 0"."""
    (v0,) = [s for s in effect("coulomb").shapes if s.smoothing]
    assert not v0.determined(0.01, 0.0)
    assert v0.determined(0.01, 0.001)
    assert not v0.determined(0.01, 0.9)
