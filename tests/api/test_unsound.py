"""What a fit must not use is refused by the API as by the command line."""

from __future__ import annotations

import csv

import pytest

from pa10d.client import ApiError


@pytest.fixture(scope="module")
def degrees(csv_file, tmp_path_factory):
    """The recording with positions in degrees, of a swing that this arm cannot do in rad."""
    path = tmp_path_factory.mktemp("degrees") / "degrees.csv"
    with csv_file.open(newline="") as there, path.open("w", newline="") as here:
        rows, out = csv.reader(there), csv.writer(here)
        out.writerow(next(rows))
        for row in rows:
            out.writerow([row[0], *(f"{57.3 * 2 * float(q):.9f}" for q in row[1:8]), *row[8:]])
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
