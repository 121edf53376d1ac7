"""A daemon in simulated time with everything behind it, once for all API tests."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import httpx
import numpy as np
import pytest

from pa10d.client import Client, local_daemon

HERE = Path(__file__).parent


def pytest_collection_modifyitems(items):
    """One daemon serves these tests in their order: they are not dealt out to workers."""
    for item in items:
        if item.path.parent == HERE:
            item.add_marker(pytest.mark.alone)


@pytest.fixture(scope="session")
def data_of_arm(tmp_path_factory) -> Path:
    """Its data folder, in which another daemon was killed while a file was sent to it."""
    folder = tmp_path_factory.mktemp("api")
    sent = folder / "uploads" / "tmp1234"
    sent.mkdir(parents=True)
    (sent / "log.csv").write_text("time,q1\n")
    return folder


@pytest.fixture(scope="session")
def arm(data_of_arm) -> Client:
    with local_daemon(data_of_arm, clock="simulated") as client:
        yield client


@pytest.fixture(scope="session")
def http(arm):
    """Plain HTTP, as a stranger would use it."""
    with httpx.Client(base_url=arm.url, timeout=30, trust_env=False) as client:
        yield client


@pytest.fixture(scope="session")
def csv_file(tmp_path_factory) -> Path:
    """A small recording of seven joints."""
    path = tmp_path_factory.mktemp("csv") / "swing.csv"
    t = np.arange(600) * 0.002
    q = 0.3 * np.sin(2 * np.pi * t)[:, None] * np.ones(7)
    with path.open("w", newline="") as file:
        out = csv.writer(file)
        joints = range(1, 8)
        out.writerow(["time", *(f"q{j}" for j in joints), *(f"tau{j}" for j in joints)])
        for k in range(len(t)):
            out.writerow([f"{t[k]:.6f}", *(f"{v:.9f}" for v in q[k]), *(f"{v:.6f}" for v in -q[k])])
    return path


@pytest.fixture(scope="module")
def guarded(tmp_path_factory):
    """A daemon with tokens, without robot behind it (nobody is on its bus)."""
    folder = tmp_path_factory.mktemp("guarded")
    tokens = folder / "tokens.json"
    tokens.write_text('{"look": "seer", "command": "mover", "admin": "root"}')
    options = ["--data", str(folder / "data"), "--json", "serve", "--port", "0", "--no-sim"]
    options += ["--channel", f"void-{os.getpid()}", "--token-file", str(tokens)]
    process = subprocess.Popen(
        [sys.executable, "-m", "pa10d", *options], stdout=subprocess.PIPE, text=True
    )
    try:
        url = json.loads(process.stdout.readline())["url"]
        with httpx.Client(base_url=url, timeout=30, trust_env=False) as client:
            yield client
    finally:
        process.terminate()
        process.wait(30)
        process.stdout.close()
