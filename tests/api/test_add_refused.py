"""What a model cannot be given is said where it is asked for: no job, nothing stored."""

from __future__ import annotations

import pytest

from backends.virtual.datasets import make_runs
from pa10d.client import ApiError
from pa10d.identify import identify
from pa10d.services.robots import load_robot
from pa10d.store.models import ModelStore


@pytest.fixture(scope="module")
def textbook(arm, data_of_arm, csv_file):
    """A textbook model in the daemon's store, and a run to fit to."""
    profile, robot = load_robot("pa10-sim")
    run = make_runs(2, [], "white", ("train_a",), profile, seconds=20.0)[0]["train_a"]
    model = identify([run], robot, name="textbook", cutoff=8.0)
    ModelStore(data_of_arm).save(model)
    return arm.upload(csv_file, "to add with")["name"]


@pytest.mark.parametrize(
    ("effect", "joints", "over", "said"),
    [
        ("coulomb", [3], (), "coulomb J3: model 'textbook' has it already"),
        ("viscous", [], (), "model 'textbook' has it already"),
        ("smooth_map", [3], (), "over nothing: expected one or two"),
        ("stribeck", [8], (), "joint 8: expected 1 to 7"),
    ],
)
def test_it_is_refused_at_once(arm, http, textbook, effect, joints, over, said):
    before = len(http.get("/api/v1/jobs").json()["items"])
    with pytest.raises(ApiError, match=said) as refused:
        arm.add("textbook", effect, joints, [textbook], "more", over=over)
    assert refused.value.status == 400
    assert len(http.get("/api/v1/jobs").json()["items"]) == before
    assert "more" not in [model["name"] for model in arm.models()]
