"""What a fit must not use is refused by the API as by the command line."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from pa10d.client import ApiError


@pytest.fixture(scope="module")
def degrees(csv_file, tmp_path_factory):
    """The recording with positions in degrees, of a swing that this arm cannot do in rad, and
    with speeds in rad/s that tell it."""
    path = tmp_path_factory.mktemp("degrees") / "degrees.csv"
    with csv_file.open(newline="") as file:
        head, *rows = csv.reader(file)
    table = np.array(rows, dtype=float)
    speeds = np.gradient(2 * table[:, 1:8], table[:, 0], axis=0)
    table[:, 1:8] = np.degrees(2 * table[:, 1:8])
    header = ",".join([*head, *(f"dq{j}" for j in range(1, 8))])
    together = np.hstack([table, speeds])
    np.savetxt(path, together, delimiter=",", header=header, comments="", fmt="%.9g")
    return path


def test_degrees_are_refused_where_they_come_in_and_where_they_are_used(arm, degrees):
    with pytest.raises(ApiError, match="these look like degrees") as refused:
        arm.upload(degrees, "refused", check=True)
    assert refused.value.problem["type"].endswith("/unsound")
    assert [f["code"] for f in refused.value.problem["findings"]] == ["degrees"]
    assert "refused" not in [run["name"] for run in arm.runs()]
    run = arm.upload(degrees, "in degrees", check=True, force=True)
    assert "degrees" in [f["code"] for f in run["findings"]]
    with pytest.raises(ApiError, match="these look like degrees") as refused:
        arm.identify(["in degrees"], "m of degrees")
    assert refused.value.status == 409
    arm.delete_run(run["id"])


def test_a_wrong_name_is_refused_before_there_is_a_job(arm, csv_file):
    run = arm.upload(csv_file, "swing of typos")
    before = len(arm._all("/api/v1/jobs", {}))
    for asked in (
        lambda: arm.identify(["swing of typos"], "m", with_effects=["strbeck"]),
        lambda: arm.start("experiments/check", {"kind": "tracking", "parameters": {"perod": 4}}),
        lambda: arm.start("experiments/check", {"kind": "chirp", "parameters": {"joints": [9]}}),
    ):
        with pytest.raises(ApiError):
            asked()
    assert len(arm._all("/api/v1/jobs", {})) == before
    arm.delete_run(run["id"])
