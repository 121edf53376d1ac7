"""Many jobs: what the daemon and its processes hold of the machine before, meanwhile and after."""

from __future__ import annotations

import time

import httpx

from attacks.target import Figures, Target, Trial

USUAL, WARM_UP, LOOKS, TO_THE_END = 2000, 100, 4, 20
ASK = {"kind": "tracking", "parameters": {"cycles": 1}}


def many_jobs(target: Target) -> Figures:
    """many jobs, one in twenty to its end, the others cancelled: what is held meanwhile"""
    count = target.times(USUAL)
    held, refused = {}, 0
    with httpx.Client(base_url=target.url, timeout=60, trust_env=False) as one:
        _jobs(one, WARM_UP)
        held[f"after {WARM_UP} to warm up"] = target.held()
        began = time.monotonic()
        for k in range(LOOKS):
            refused += _jobs(one, count * (k + 1) // LOOKS - count * k // LOOKS)
            held[f"after {count * (k + 1) // LOOKS} more"] = target.held()
        seconds = time.monotonic() - began
    return {"jobs": count, "seconds": seconds, "told_to_wait": refused, "held": held}


def _jobs(one: httpx.Client, count: int) -> int:
    """Start and cancel them, as impatient clients do; how often there was no room for one more."""
    refused = 0
    for k in range(count):
        while (answer := one.post("/api/v1/experiments/check", json=ASK)).status_code == 429:
            refused += 1
            time.sleep(0.2)
        job = answer.json()["id"]
        if k % TO_THE_END:
            one.post(f"/api/v1/jobs/{job}/cancel")
        else:
            while one.get(f"/api/v1/jobs/{job}").json()["status"] in ("queued", "running"):
                time.sleep(0.05)
    return refused


TRIALS: tuple[Trial, ...] = (many_jobs,)
