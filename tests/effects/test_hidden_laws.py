"""Laws of other packages in the simulated arm: what ``demo --hide`` and the kit hide by name."""

from __future__ import annotations

import importlib
import sys

import numpy as np
import pytest
from test_third_party import LAW, MODULE, installed  # noqa: F401

from backends.virtual.datasets import figures_of, make_runs, random_effect
from backends.virtual.plant import laws
from backends.virtual.plant.plant import build
from pa10d.common.errors import UserError
from pa10d.demo.hidden import hide, with_secret
from pa10d.effect_kit import check
from pa10d.effects import effect
from pa10d.profile import load_profile

NAME = "creeping_hose"


@pytest.fixture
def hiding(installed, tmp_path):  # noqa: F811
    """The guide's package with its law, or with other code in its place."""
    modules = []

    def do(code=LAW, name=NAME):
        installed()
        module = f"{MODULE}_hidden"
        (tmp_path / f"{module}.py").write_text(code, encoding="utf-8")
        (info,) = tmp_path.glob("*.dist-info")
        points = (info / "entry_points.txt").read_text()
        points += f"[pa10d.hidden]\n{name} = {module}:HiddenHose\n"
        (info / "entry_points.txt").write_text(points)
        modules.append(module)
        importlib.invalidate_caches()
        laws.laws.cache_clear()

    yield do
    laws.laws.cache_clear()
    for module in modules:
        sys.modules.pop(module, None)


def test_the_demo_hides_it_where_it_is_asked_to(hiding):
    profile = load_profile("pa10-sim")
    with pytest.raises(UserError, match="no such effect"):
        hide("creeping_hose:2", 3, profile)
    hiding()
    secret = hide("creeping_hose:2", 3, profile)
    assert (secret.name, secret.joints) == (NAME, (2,))
    assert secret.effects[0]["k"] > 0
    assert with_secret(profile, secret, 3).simulation.options["effects"] == [
        dict(secret.effects[0])
    ]
    with pytest.raises(UserError, match="expected 1 to 7"):
        hide("creeping_hose:8", 3, profile)


def test_an_effect_without_a_law_says_so(installed):  # noqa: F811
    installed()
    with pytest.raises(UserError, match="its package has no law for the simulated arm"):
        hide("creeping_hose:2", 3, load_profile("pa10-sim"))


@pytest.mark.long
def test_the_arm_feels_it_step_by_step_and_in_a_whole_run_alike(hiding):
    hiding()
    profile = load_profile("pa10-sim")
    hidden = [{"effect": NAME, "joint": 2, "k": 60.0, "T": 1e9}]  # a spring, as good as
    plain, soft = (build(profile, effects=e, noise="none") for e in ([], hidden))
    push = np.zeros(7)
    for plant in (plain, soft):
        plant.reset(np.zeros(7))
    push[1] = 60.0
    ways = []
    for plant in (plain, soft):
        for _ in range(100):
            plant.step(push, 0.002)
        ways.append(plant.state.q[:7].copy())
    assert ways[0][1] > 1.02 * ways[1][1] > 0.0, "the hose pulls back"
    stretch = ways[1][1]
    assert soft.state.outside[1] == pytest.approx(60.0 * stretch, rel=0.05)
    kinds = ("train_a",)
    (one,), (other,) = (make_runs(5, e, kinds=kinds, seconds=4.0)[0].values() for e in ([], hidden))
    assert np.abs(other.tau[:, 1] - one.tau[:, 1]).max() > 5.0
    soft.reset(np.zeros(7))
    assert not soft.state.outside.any(), "a new beginning forgets"


def test_a_draw_shows(hiding):
    hiding()
    drawn = random_effect(np.random.default_rng(1), NAME, figures_of("pa10-sim"))
    assert drawn["effect"] == NAME
    assert {"joint", "k", "T"} <= drawn.keys()


@pytest.mark.parametrize(
    ("old", "new", "name", "message"),
    [
        ('where = "joint"', 'where = "wrist"', NAME, "where is 'wrist'"),
        ("    def torque", "    def torques", NAME, "torque is None"),
        ("class HiddenHose", "class Hose", NAME, "cannot be loaded"),
        ("", "", "stribeck", "knows 'stribeck' already"),
    ],
)
def test_what_is_wrong_with_it_is_one_line_with_its_package(hiding, old, new, name, message):
    hiding(LAW.replace(old, new, 1), name)
    with pytest.raises(UserError, match=message) as told:
        hide("creeping_hose:2", 3, load_profile("pa10-sim"))
    assert "package creeping-hose" in str(told.value)
    assert "\n" not in str(told.value)


def test_a_law_that_fails_in_motion_is_one_line(hiding):
    hiding(LAW.replace("return self.k * self.stretch", "return self.k * self.strech"))
    hidden = [{"effect": NAME, "joint": 2, "k": 60.0}]
    plant = build(load_profile("pa10-sim"), effects=hidden)
    with pytest.raises(UserError, match=r"hidden creeping_hose: its torque: .*strech"):
        plant.step(np.zeros(7), 0.002)
    with pytest.raises(UserError, match="creeping_hose needs a value for k"):
        build(load_profile("pa10-sim"), effects=[{"effect": NAME, "joint": 2}])


@pytest.mark.long
def test_what_its_own_law_hides_is_found_again(hiding):
    hiding()
    assert [v for v in check(effect(NAME), 1, hide=True) if not v.passed] == []
