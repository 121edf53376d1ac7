"""An hour at 500 Hz goes in and out within the memory that was promised."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import csv

IMPORT = """
import json, resource, sys, time
from pa10d.cli import main
begin = time.perf_counter()
status = main(["--data", sys.argv[2], "run", "import", sys.argv[1], "--profile", "pa10-sim"])
middle = time.perf_counter()
from pa10d.store import RunStore
recording = RunStore(sys.argv[2]).recording("hour")
end = time.perf_counter()
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
print(json.dumps({"status": status, "import": middle - begin, "load": end - middle,
                  "peak": peak, "shape": recording.q.shape, "rate": recording.rate}))
"""


@pytest.mark.long
@pytest.mark.parametrize("jitter", [0.0, 4e-4], ids=["steady", "irregular"])
def test_an_hour_imports_and_loads_within_two_gigabytes(tmp_path, jitter):
    count = 1_800_000
    rng = np.random.default_rng(0)
    t = np.arange(count) * 0.002
    table = {"time": np.round(t + rng.uniform(-jitter, jitter, count), 7)}
    table |= {f"q{j}": np.round(np.sin(t * (0.2 + 0.1 * j)), 7) for j in range(1, 8)}
    table |= {f"tau{j}": np.round(rng.normal(size=count), 4) for j in range(1, 8)}
    csv.write_csv(pa.table(table), tmp_path / "hour.csv")
    done = subprocess.run(
        [sys.executable, "-c", IMPORT, str(tmp_path / "hour.csv"), str(tmp_path / "data")],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    figures = json.loads(done.stdout.splitlines()[-1])
    assert figures["status"] == 0
    assert figures["shape"][0] == pytest.approx(count, abs=2)
    assert figures["rate"] == pytest.approx(500, rel=1e-9)
    assert figures["peak"] < 2e9
    assert figures["import"] < 60
    print(figures)
