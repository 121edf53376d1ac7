"""A virtual arm's night: what changed came with it, by a button, and is told when asked for."""

from __future__ import annotations

import argparse
import contextlib
import json
import subprocess
import sys
from dataclasses import replace

import pytest
from loops import run_apart
from small_arm import small_arm

from pa10d.cli.daemon import _with_secret
from pa10d.client import ApiError, running_at
from pa10d.common.errors import UserError
from pa10d.daemon.night import FILE, Drawn, Night, Secret, drawn_before
from pa10d.demo.hidden import Hidden, hide
from pa10d.profile import load_profile

PROFILE = load_profile("pa10-sim")
SECRET = Secret(PROFILE, "payload (mass = 2.0)", True)


async def nothing(profile):
    """The arm is switched off and on again."""


def test_an_arm_without_a_secret_has_no_nights():
    night = Night(None)
    assert night.document()["hides"] is False
    with pytest.raises(UserError, match="hides nothing"):
        night.reveal()
    with pytest.raises(UserError, match="hides nothing"):
        run_apart(night.passes(nothing))


def test_it_passes_once_and_tells_nothing():
    night, seen = Night(SECRET), []

    async def switched(profile):
        seen.append(profile)

    run_apart(night.passes(switched))
    assert (night.day, seen) == (2, [PROFILE])
    assert "payload" not in json.dumps(night.document())
    with pytest.raises(UserError, match="day 2"):
        run_apart(night.passes(switched))
    night.reveal()
    assert night.document()["hidden"] == "payload (mass = 2.0)"
    assert night.document()["since_the_night"] is True


def test_an_arm_that_does_not_come_back_has_seen_no_day_2():
    night = Night(SECRET)

    async def fails(profile):
        raise UserError("it does not answer")

    with pytest.raises(UserError, match="does not answer"):
        run_apart(night.passes(fails))
    assert night.day == 1
    run_apart(night.passes(nothing))
    assert night.day == 2


@pytest.mark.long
def test_what_a_draw_changes_is_not_there_on_the_first_day():
    """Whatever is drawn, one of the two questions of the page can show it."""
    for seed in range(60):
        drawn = hide(None, seed, PROFILE)
        assert drawn.changes is (drawn.present(later=False) == [])
        assert drawn.present(later=True)
    assert Hidden(({"effect": "payload", "mass": 1.0},)).changes
    assert not Hidden().changes


def test_day_and_arm_stay_with_the_data(tmp_path):
    drawn = Drawn("pa10-sim", "any", 7)
    secret = replace(SECRET, drawn=drawn)
    assert drawn_before(tmp_path) is None
    night = Night(secret, tmp_path)
    assert drawn_before(tmp_path) == drawn
    run_apart(night.passes(nothing))
    kept = drawn_before(tmp_path)
    assert kept is not None
    assert (kept.seed, kept.day, kept.revealed) == (7, 2, False)
    again = Night(replace(SECRET, drawn=kept), tmp_path)
    with pytest.raises(UserError, match="day 2"):
        run_apart(again.passes(nothing))
    again.reveal()
    assert Night(replace(SECRET, drawn=drawn_before(tmp_path)), tmp_path).revealed
    for broken in (
        "",
        "[]",
        '{"seed": "x"}',
        '{"profile": "p", "hide": "any", "seed": 1, "day": 5}',
    ):
        (tmp_path / FILE).write_text(broken)
        with pytest.raises(UserError, match=rf"{FILE}: found no virtual arm in it, expected the"):
            drawn_before(tmp_path)
    Night(secret, tmp_path)
    assert drawn_before(tmp_path) == drawn, "who names it writes it anew"


def served(data, hide=None, seed=None, profile=PROFILE):
    """What ``serve`` with these options hides."""
    options = argparse.Namespace(data=str(data), hide=hide, seed=seed)
    return _with_secret(profile, options)[1]


def test_another_arm_for_the_same_data_is_told(tmp_path, capsys):
    Night(replace(SECRET, drawn=Drawn("pa10-sim", "stribeck:4", 3305)), tmp_path)
    assert served(tmp_path, "stribeck:4").drawn.seed == 3305
    assert "these data are of another" not in capsys.readouterr().err
    for hide_, seed in (("any", None), ("stribeck:4", 7), (None, 7)):
        served(tmp_path, hide_, seed)
        said = capsys.readouterr().err
        assert "of another virtual arm so far (pa10-sim, --hide stribeck:4 --seed 3305, " in said


def test_data_whose_arm_is_not_known_are_not_gone_on_with_in_silence(tmp_path):
    (tmp_path / FILE).write_text("")
    for hide_, seed in ((None, None), ("any", None), ("stribeck:4", None), (None, 7)):
        with pytest.raises(UserError, match=r"name it as it was \(--hide EFFECT --seed N\)"):
            served(tmp_path, hide_, seed)
    assert served(tmp_path, "stribeck:4", 3305).drawn == Drawn("pa10-sim", "stribeck:4", 3305)
    real = PROFILE.model_copy(update={"simulation": None})
    assert served(tmp_path, profile=real) is None, "no virtual arm, none to be known"


@contextlib.contextmanager
def hiding(data, *options):
    command = [sys.executable, "-m", "pa10d", "--data", str(data), "--json", "serve", *options]
    command += ["--port", "0", "--clock", "simulated", "--channel", f"night-{data.name}"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        with running_at(json.loads(process.stdout.readline())["url"], data) as client:
            yield client
    finally:
        process.terminate()
        process.wait(30)
        process.stdout.close()


@pytest.mark.long
@pytest.mark.alone
def test_the_arm_comes_back_and_keeps_its_secret(tmp_path):
    path = str(small_arm(tmp_path))
    with hiding(tmp_path, "--profile", path, "--hide", "payload", "--seed", "4") as client:
        ask = client._ask
        assert ask("GET", "/api/v1/story")["day"] == 1
        client.enable()
        with pytest.raises(ApiError, match="expected inactive"):
            ask("POST", "/api/v1/story/night")
        client.disable()
        assert ask("POST", "/api/v1/story/night")["day"] == 2
        assert client.enable()["state"] == "holding"
        client.disable()
        assert ask("GET", "/api/v1/story")["hidden"] is None
        with pytest.raises(ApiError, match="day 2"):
            ask("POST", "/api/v1/story/night")
        assert ask("POST", "/api/v1/story/reveal")["hidden"].startswith("payload (mass = ")
    left = served(tmp_path, profile=load_profile(path))  # nothing asked for: the arm that was left
    assert left.drawn == replace(drawn_before(tmp_path), day=2, revealed=True)
    assert left.words.startswith("payload (mass = ")


@pytest.mark.alone
@pytest.mark.long
def test_the_next_daemon_has_the_arm_that_was_left(tmp_path):
    with hiding(tmp_path, "--hide", "payload", "--seed", "4") as client:
        assert client._ask("POST", "/api/v1/story/night")["day"] == 2
    with hiding(tmp_path) as client:
        ask = client._ask
        assert ask("GET", "/api/v1/story")["day"] == 2
        with pytest.raises(ApiError, match="day 2"):
            ask("POST", "/api/v1/story/night")
        assert ask("POST", "/api/v1/story/reveal")["hidden"].startswith("payload (mass = ")
