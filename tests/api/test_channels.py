"""Channels over HTTP: what is there, stretches as Arrow, spectra, faults, what is left out."""

from __future__ import annotations

import base64
import json

import numpy as np
import pyarrow as pa
import pytest

from pa10d.control.record import SCALARS, VECTORS
from pa10d.services.explorer import channels, columns, faults, spectrum

RATE, TONE = 200.0, 17.0  # Hz


@pytest.fixture(scope="module")
def tone(http, tmp_path_factory) -> str:
    """A run of seven joints: 20 s, a tone of 17 Hz in joint 2's torque and ten lines per
    revolution in joint 3's, one sample of joint 4 far off; a further column."""
    t = np.arange(0, 20, 1 / RATE)
    q = 0.8 * np.sin(2 * np.pi * 0.1 * t)[:, None] * np.ones(7)
    tau = 0.1 * np.ones((len(t), 7))
    tau[:, 1] += 0.5 * np.sin(2 * np.pi * TONE * t)
    tau[:, 2] += 0.3 * np.sin(10 * q[:, 2])
    tau[2345, 3] = 9.0
    head = ["time", *(f"q{j}" for j in range(1, 8)), *(f"tau{j}" for j in range(1, 8)), "door"]
    table = np.column_stack([t, q, tau, t > 10])
    text = ",".join(head) + "\n" + "\n".join(",".join(f"{v:.9g}" for v in row) for row in table)
    answer = http.post("/api/v1/runs", content=text, params={"filename": "tone.csv"})
    assert answer.status_code == 201, answer.text
    return answer.json()["id"]


def read(answer) -> pa.Table:
    assert answer.status_code == 200, answer.text
    return pa.ipc.open_stream(answer.content).read_all()


def test_channels_name_what_was_recorded(http, tone):
    found = http.get("/api/v1/channels", params={"run": tone}).json()
    assert (found["samples"], found["rate"]) == (4000, pytest.approx(RATE))
    known = {one["id"]: one for one in found["channels"]}
    assert {"q1", "dq7", "tau4", "door"} <= set(known)
    assert known["tau4"] == {"id": "tau4", "group": "torque measured", "unit": "N·m", "joint": 4}


def test_a_stretch_keeps_the_peak_and_a_zoom_every_sample(http, tone):
    ask = {"run": tone, "channel": ["tau4", "q1"], "points": 200}
    whole = read(http.get("/api/v1/columns", params=ask))
    assert whole.num_rows <= 202
    peak = np.argmax(whole["tau4"].to_numpy())
    assert whole["tau4"].to_numpy()[peak] == pytest.approx(9.0)
    assert whole["time"].to_numpy()[peak] == pytest.approx(2345 / RATE, abs=40 / 200 * 2)
    part = read(http.get("/api/v1/columns", params=ask | {"begin": 11.5, "end": 12.0}))
    time = part["time"].to_numpy()
    assert np.diff(time) == pytest.approx(1 / RATE)
    assert (time[0], time[-1]) == (pytest.approx(11.5), pytest.approx(12.0))
    assert part["q1"].to_numpy() == pytest.approx(0.8 * np.sin(2 * np.pi * 0.1 * time), abs=1e-5)


def test_the_velocity_follows_from_the_position(http, tone):
    found = read(
        http.get("/api/v1/columns", params={"run": tone, "channel": "dq1", "points": 4000})
    )
    time, dq = found["time"].to_numpy()[200:-200], found["dq1"].to_numpy()[200:-200]
    wanted = 0.8 * 2 * np.pi * 0.1 * np.cos(2 * np.pi * 0.1 * time)
    assert np.abs(dq - wanted).max() < 2e-3


def test_a_tone_stands_at_its_frequency_with_its_amplitude(http, tone):
    found = read(http.get("/api/v1/spectrum", params={"run": tone, "channel": "tau2"}))
    f, height = found["frequency"].to_numpy(), found["tau2"].to_numpy()
    assert f[np.argmax(height)] == pytest.approx(TONE, abs=0.2)
    assert height.max() == pytest.approx(0.5, rel=0.16)  # at most 1.4 dB less between two lines


def test_ten_lines_per_revolution_stand_at_order_ten(http, tone):
    ask = {"run": tone, "channel": "tau3", "orders": True}
    found = read(http.get("/api/v1/spectrum", params=ask))
    order, height = found["order"].to_numpy(), found["tau3"].to_numpy()
    above = order > 5
    assert order[above][np.argmax(height[above])] == pytest.approx(10.0, abs=2.0)


@pytest.mark.parametrize(
    ("path", "query", "status", "says"),
    [
        ("columns", {"channel": "q1"}, 400, "expected 'run' or 'fault'"),
        ("columns", {"run": "nobody", "channel": "q1"}, 404, "nobody"),
        ("columns", {"run": "RUN", "channel": "q9"}, 400, "expected one of q1"),
        ("columns", {"run": "RUN", "channel": "q1", "begin": 3, "end": 2}, 400, "begin before end"),
        ("channels", {"fault": "../x"}, 400, "no such record"),
        ("spectrum", {"run": "RUN", "channel": "door", "orders": True}, 400, "no orders"),
    ],
)
def test_what_is_wrong_is_said(http, tone, path, query, status, says):
    query = {key: tone if value == "RUN" else value for key, value in query.items()}
    answer = http.get(f"/api/v1/{path}", params=query)
    assert answer.status_code == status
    assert says in answer.json()["detail"]


def test_stretches_are_left_out_and_taken_back(http, tone):
    changed = http.patch(f"/api/v1/runs/{tone}", json={"excluded": [[4, 5], [4.5, 6]]})
    assert changed.json()["excluded"] == [[4, 6]]
    wrong = http.patch(f"/api/v1/runs/{tone}", json={"excluded": [[18, 25]]})
    assert wrong.status_code == 400
    assert "within 0 to 19.995 s" in wrong.json()["detail"]
    assert http.patch(f"/api/v1/runs/{tone}", json={"excluded": []}).json()["excluded"] == []


def test_answers_are_packed_where_that_is_understood(http, tone):
    ask = {"run": tone, "channel": ["q1", "q2"], "points": 2000}
    packed = http.get("/api/v1/columns", params=ask)
    plain = http.get("/api/v1/columns", params=ask, headers={"Accept-Encoding": "identity"})
    assert packed.headers["content-encoding"] == "gzip"
    assert "content-encoding" not in plain.headers
    assert packed.content == plain.content
    assert int(packed.headers["content-length"]) < len(plain.content)


@pytest.fixture
def fault(tmp_path) -> str:
    """A data folder with a record such as a fault leaves."""
    (tmp_path / "faults").mkdir()
    t = 100.0 + np.arange(2500) * 0.002
    fields = {name: np.zeros(2500) for name in SCALARS} | {
        name: np.zeros((2500, 2)) for name in VECTORS
    }
    fields["time"] = t
    fields["q"] = np.column_stack([np.sin(t), np.cos(t)])
    fields["q_ref"] = fields["q"] + 0.25
    said = {"kind": "stale", "joint": 2, "cause": "no news"}
    about = np.array(json.dumps({"fault": said, "joints": ["a", "b"]}))
    np.savez(tmp_path / "faults/20260102-030405-stale.npz", about=about, **fields)
    (tmp_path / "faults/broken.npz").write_bytes(b"nothing")
    return str(tmp_path)


def test_the_last_seconds_before_a_fault_are_channels_too(fault):
    (one,) = faults(fault).items
    assert (one.id, one.joint, one.sentence) == (
        "20260102-030405-stale",
        2,
        "joint 2: no news",
    )
    about = channels(fault, "", "fault", one.id, [])
    assert about.start == pytest.approx(-4.998)
    assert about.joints == ["a", "b"]
    text = columns(fault, "", "fault", one.id, [], ["error2"], None, 5000, False)
    table = pa.ipc.open_stream(base64.b64decode(text)).read_all()
    assert table["error2"].to_numpy() == pytest.approx(0.25)
    assert spectrum(fault, "", "fault", one.id, [], ["q1"], None, False)
