"""From a stored run to the part of it that a step looks at."""

from __future__ import annotations

import json

import numpy as np

from pa10d.measurement.recording import Recording
from pa10d.paper.results import Following
from pa10d.paper.spans import steady_parts
from pa10d.services.library import Library
from pa10d.trajectory.plan import Plan


def plan_of(library: Library, run: str) -> Plan:
    """The plan that a run recorded."""
    stored = library.runs.read(library.runs.find(run))
    return Plan.from_dict(json.loads(stored.metadata["pa10d.plan"]["plan"]))


def steady(library: Library, run: str) -> Recording:
    """The run of a plan of one motion without its way in and out: whole periods."""
    recording = library.runs.recording(library.runs.find(run))
    begin = float(recording.t[0]) - 1.0 / recording.rate  # the first sample is one tick into it
    return next(iter(steady_parts(recording, plan_of(library, run), begin).values()))


def followed(library: Library, run: str) -> Following:
    """What was commanded minus what was measured, over whole cycles."""
    samples = library.runs.read(library.runs.find(run)).samples
    assert samples.commands is not None  # the daemon's runs have them
    t = (samples.stamps - samples.stamps[0]) * 1e-9
    span = plan_of(library, run).spans[0]
    inside = (t >= span.begin) & (t < span.end)
    error = samples.commands.q[inside] - samples.q[inside]
    return Following(t[inside] - span.begin, np.asarray(error, dtype=float))
