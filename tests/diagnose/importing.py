"""Recordings of the two links in a data folder, as a user brings them there."""

from __future__ import annotations

import numpy as np
from two_links import URDF

from pa10d.cli import main


def imported(folder, recordings):
    """recordings: by name; → the data folder and the profile, as arguments of commands."""
    (folder / "two.urdf").write_text(URDF)
    profile = folder / "two.yaml"
    profile.write_text("urdf: two.urdf\n")
    store = str(folder / "data")
    for name, run in recordings.items():
        file = folder / f"{name}.csv"
        columns = np.column_stack([run.t, run.q, run.tau])
        np.savetxt(file, columns, "%.9g", ",", header="time,q1,q2,tau1,tau2", comments="")
        assert main(["--data", store, "run", "import", str(file), "--profile", str(profile)]) == 0
    return store, str(profile)
