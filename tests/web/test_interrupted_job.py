"""A job that a killed daemon left behind: the next one tells of it, and so does its page."""

from __future__ import annotations

import json

import pytest
from benches import served

STARTED = "2026-01-01T00:00:00.000+00:00"
LEFT = {
    "id": "20260101-000000000-abcdef", "kind": "identify", "request": {"name": "m0"},
    "created": STARTED, "status": "running", "progress": 0.4, "message": "filtering",
    "result": None, "error": None, "started": STARTED, "finished": None,
}  # fmt: skip


@pytest.mark.long
def test_it_is_known_after_a_restart(tmp_path, browser, visit):
    (tmp_path / "jobs").mkdir()
    (tmp_path / "jobs" / f"{LEFT['id']}.json").write_text(json.dumps(LEFT))
    with served(tmp_path, f"left-{tmp_path.name[-20:]}") as url:
        visitor = visit(url)
        page = visitor.page
        job = page.request.get(f"{url}/api/v1/jobs/{LEFT['id']}")
        assert job.status == 200
        assert (job.json()["status"], job.json()["message"]) == ("failed", "interrupted")
        assert job.json()["result"] is None
        visitor.open("models")
        page.locator(
            "#jobs", has_text="Last: Fit failed: the daemon ended before it was"
        ).wait_for()
        assert not visitor.errors
