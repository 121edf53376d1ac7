"""A control process that hangs is ended, and whatever ends one is told with its last words."""

from __future__ import annotations

import asyncio
import os

import pytest

from pa10d.daemon.processes.child import Child
from pa10d.daemon.robot.liveness import COMMANDED, HANGS, Liveness

EVERY = 0.5


def ticks_until_it_is_given_up(liveness, written=lambda k: 0, commanded=False):
    for k in range(1000):
        if (why := liveness.tick(written(k), commanded)) is not None:
            return k, why
    return None


def test_silence_without_cycles_is_given_up():
    liveness = Liveness(EVERY)
    count, why = ticks_until_it_is_given_up(liveness)
    assert liveness.quiet == pytest.approx(count * EVERY, abs=2 * EVERY)
    liveness.heard()
    assert liveness.quiet == 0.0
    assert HANGS <= count * EVERY <= HANGS + 1.0
    assert f"nothing was heard of it for {HANGS:g} s" in why
    assert "backend hangs" in why
    count, _ = ticks_until_it_is_given_up(Liveness(EVERY), commanded=True)
    assert COMMANDED <= count * EVERY <= COMMANDED + 1.0


def test_patience_with_a_command_outlasts_whoever_asked_for_it():
    """The answer is waited for 60 s; what configures drives for 70 s is no hanging backend."""
    liveness = Liveness(EVERY)
    for _ in range(round(60.0 / EVERY)):
        assert liveness.tick(7, commanded=True) is None
    count, why = ticks_until_it_is_given_up(liveness, lambda _: 7)
    assert COMMANDED <= 60.0 + count * EVERY <= COMMANDED + 1.0
    assert f"nothing was heard of it for {COMMANDED:g} s" in why


@pytest.mark.parametrize("life", ["a word", "a cycle"])
def test_patience_with_a_command_ends_with_a_sign_of_life(life):
    liveness = Liveness(EVERY)
    for _ in range(round(60.0 / EVERY)):
        assert liveness.tick(7, commanded=True) is None
    if life == "a word":
        liveness.heard()
    count, why = ticks_until_it_is_given_up(liveness, lambda _: 7 if life == "a word" else 8)
    assert HANGS <= count * EVERY <= HANGS + 1.0
    assert f"nothing was heard of it for {HANGS:g} s" in why


def test_cycles_or_words_are_life_enough():
    assert ticks_until_it_is_given_up(Liveness(EVERY), written=lambda k: k) is None
    liveness = Liveness(EVERY)
    for _ in range(1000):
        assert liveness.tick(7, commanded=False) is None
        liveness.heard()


@pytest.fixture
def ending(tmp_path, monkeypatch):
    """A module that speaks over the pipe and ends, or does not."""
    (tmp_path / "ending.py").write_text(
        "import json, socket, sys, time\n"
        "pipe = socket.socket(fileno=int(sys.argv[-1]))\n"
        "def tell(**message): pipe.send(json.dumps(message).encode())\n"
        "tell(event='ready')\n"
        "if sys.argv[1] == 'hang': time.sleep(600)\n"
        "for k in range(50): tell(event='state', number=k)\n"
        "tell(event='ends', why='TypeError: unsupported operand')\n"
        "sys.exit(3)\n"
    )
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    monkeypatch.setenv("PYTHONPATH", path)
    return "ending"


def test_last_words_are_heard_though_the_process_is_gone(ending):
    async def main():
        heard = []
        child = await Child.start("c", ending, ["end"], heard.append)
        await child.process.wait()
        await child.end(1.0, polite=False)
        return child, heard

    child, heard = asyncio.run(main())
    assert [message["number"] for message in heard] == list(range(50))
    assert child.how_it_ended() == "ended with status 3: TypeError: unsupported operand"


def test_one_that_hangs_is_broken_off_and_said_to(ending, monkeypatch):
    monkeypatch.setattr("pa10d.daemon.processes.child.LEAVES_TRACE", 60.0)

    async def main():
        child = await Child.start("c", ending, ["hang"], lambda _: None)
        await child.ready(30.0)
        await child.break_off("it hung")
        await child.end(1.0, polite=False)
        return child

    assert asyncio.run(main()).how_it_ended() == "was ended by signal 6: it hung"
