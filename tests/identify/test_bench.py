"""The benchmarks answer, and say what the README quotes."""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[2] / "scripts"))
bench = importlib.import_module("bench")


def test_an_unknown_kind_is_wrong_usage(capsys):
    with pytest.raises(SystemExit) as stopped:
        bench.main(["speed"])
    assert stopped.value.code == 2
    assert "identify" in capsys.readouterr().err


def test_unknown_options_are_wrong_usage():
    with pytest.raises(SystemExit) as stopped:
        bench.main(["identify", "--faster"])
    assert stopped.value.code == 2


def test_a_kind_is_a_module_with_options(tmp_path, monkeypatch, capsys):
    (tmp_path / "bench_loop.py").write_text(
        "def run(cycles: int = 3):\n    return {'cycles': cycles}\n"
        "def sentences(figures):\n    return f'{figures[\"cycles\"]} cycles'\n"
    )
    monkeypatch.setattr(bench, "HERE", tmp_path)
    monkeypatch.delitem(sys.modules, "bench_loop", raising=False)
    monkeypatch.setattr(sys, "path", list(sys.path))
    assert bench.main(["loop", "--cycles", "5"]) == 0
    assert capsys.readouterr().out == "5 cycles\n"
    assert bench.main(["loop", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"cycles": 3}
    monkeypatch.delitem(sys.modules, "bench_loop")
    assert bench.main(["excitation"]) == 1
    assert "bench_excitation.py is missing" in capsys.readouterr().err


def test_the_bare_reference_of_an_identification_finds_the_same_torque():
    bench_identify = importlib.import_module("bench_identify")
    plain_peer = importlib.import_module("plain_peer")
    robot = bench_identify.arm()
    beta, errors = plain_peer.identify(robot, bench_identify.data(robot, 1500, seed=1))
    assert len(beta) == len(errors) == 62
    assert np.all(errors > 0)


def test_a_bare_exchange_of_frames_is_timed():
    pace = importlib.import_module("ping_pong").ping_pong([1, 2, 3], 50)
    assert 0 < pace.processor <= pace.wall


@pytest.mark.long
def test_identification_is_fast_and_right(capsys):
    assert bench.main(["identify", "--repeats", "1", "--figaroh", "no", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    small, large = figures["runs"]
    assert (small["samples"], large["samples"]) == (10_000, 100_000)
    assert small["parameters"] == 62
    assert small["seconds"] < 2.0  # 0.15 s on an idle core
    assert large["seconds"] < 15.0
    assert max(large["torque_error"]) < 0.05
