"""One value says how a model is fitted, whoever asks: science, commands, API or library."""

from __future__ import annotations

import inspect
from dataclasses import FrozenInstanceError, fields

import pytest
from synthetic import fourier, pa10_truth, recording

from pa10d.api.schemas.analyses import IdentifyRequest
from pa10d.common.errors import UserError
from pa10d.daemon.jobs import tasks
from pa10d.identify import FitOptions, identify
from pa10d.services.models import identified, identify_runs

NAMES = {field.name for field in fields(FitOptions)}
ASKED = {
    "cutoff": 10.0, "with_effects": ["torque_offset"], "robust": True, "faster_than": [0.1, 0.2],
    "prior": 30.0, "given": ["Fc1=12±2", "link J1: m = 2 +- 10 %"],
}  # fmt: skip
READ = FitOptions(
    10.0, ("torque_offset",), True, (0.1, 0.2), 30.0, (("Fc1", 12.0, 2.0), ("link J1: m", 2.0, 0.2))
)


def test_a_request_has_its_fields_by_name_and_its_defaults():
    assert IdentifyRequest.model_fields.keys() >= NAMES
    plain = IdentifyRequest(runs=["one"], name="m0")
    assert FitOptions.read(plain.model_dump()) == FitOptions()
    assert ASKED.keys() == NAMES, "a new option stands in this test, too"
    asked = IdentifyRequest(runs=["one"], name="m0", **ASKED)
    assert FitOptions.read(asked.model_dump()) == READ


def test_nobody_on_the_way_names_them_again():
    for way in (identify_runs, identified, tasks.identify, identify):
        named = inspect.signature(way).parameters.keys()
        assert not NAMES & named, way
        assert len(named) <= 11, way


def test_it_is_a_value():
    assert len({READ, FitOptions.read(ASKED)}) == 1
    with pytest.raises(FrozenInstanceError):
        READ.cutoff = 3.0
    with pytest.raises(UserError, match="expected NAME=VALUE±ERROR"):
        FitOptions.read({"given": ["Fc1 is 12"]})


@pytest.mark.long
def test_single_options_by_name_are_the_same():
    truth = pa10_truth(2)
    run = recording(truth, fourier(2, 8.0, 250.0))
    one = identify([run], truth.robot, name="m", options=FitOptions(9.0, robust=True))
    other = identify([run], truth.robot, name="m", cutoff=9.0, robust=True)
    both = identify([run], truth.robot, name="m", options=FitOptions(5.0, robust=True),
                    cutoff=9.0)  # fmt: skip
    assert one.cutoff == other.cutoff == both.cutoff == 9.0
    assert (one.h == other.h).all()
    assert (one.h == both.h).all()
    with pytest.raises(TypeError, match="cut_off"):
        identify([run], truth.robot, name="m", cut_off=9.0)
