"""``pa10d excite`` as a person calls it."""

from __future__ import annotations

import json

import pytest
import yaml
from sample_arms import around_pa10, pa10

from pa10d.cli import main
from pa10d.trajectory.check import check
from pa10d.trajectory.kinds import read_request
from pa10d.trajectory.limits import limits_of

QUICK = ["--generations", "0", "--workers", "1", "--harmonics", "2", "--samples", "40"]


def test_the_file_is_a_plan_and_the_answer_says_how_good_it_is(tmp_path, capsys):
    out = tmp_path / "traj.yaml"
    status = main(["excite", "--joints", "3-4", *QUICK, "--out", str(out), "--json"])
    said = capsys.readouterr()
    answer = json.loads(said.out)
    assert status == 0
    assert answer["out"] == str(out)
    assert 1.0 < answer["condition_number"] < 200.0
    assert "plan:" in said.err
    request = yaml.safe_load(out.read_text())
    assert request["kind"] == "excitation"
    plan = read_request(request).build(around_pa10())
    assert plan.joints == (3, 4)
    assert check(plan, pa10(), limits_of(pa10())) == []
    assert request["about"]["condition_number"] == answer["condition_number"]


@pytest.mark.long
def test_without_a_file_the_plan_is_in_the_answer(capsys):
    assert main(["excite", "--joints", "3,4", *QUICK, "--period", "8", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    request = read_request(answer["plan"])
    assert request.build(around_pa10()).spans[0].label == "3 periods of 8 s"


def test_people_get_a_table(capsys):
    assert main(["excite", "--joints", "4", *QUICK, "--even", "1", "--smallest", "2"]) == 0
    text = capsys.readouterr().out
    assert "condition number" in text
    assert "of its velocity" in text


@pytest.mark.parametrize(
    ("options", "status", "words"),
    [
        (["--joints", "x"], 2, "--joints: found 'x', expected such as 1-4"),
        (["--joints", "1-9"], 1, "joints: found 8, expected 1 to 7"),
        (["--floor", "low"], 2, "--floor: found 'low', expected a height"),
        (["--samples", "3"], 1, "samples: 3 in a period"),
        (["--out", "/nowhere/at/all.yaml"], 1, "/nowhere/at/all.yaml: no such folder"),
        (["--joints", "1-2", "--boundary", "0.1"], 1, "boundary: found 1 values, expected 2"),
    ],
)
def test_what_is_wrong_is_one_line(options, status, words, capsys):
    assert main(["excite", "--generations", "0", "--workers", "1", *options]) == status
    said = capsys.readouterr()
    assert words in said.err
    assert said.out == ""


def test_wrong_usage_is_status_2():
    with pytest.raises(SystemExit) as caught:
        main(["excite", "--seconds", "-3"])
    assert caught.value.code == 2
