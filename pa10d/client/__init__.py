"""A thin client of the daemon's API, for programs, the demo and the command line.

with local_daemon(data, profile="pa10-sim") as arm:
    job = arm.experiment("tracking", {"seconds": 20})
    print(job["result"]["runs"])
"""

from pa10d.client.client import Client
from pa10d.client.connection import ApiError, JobFailed
from pa10d.client.daemons import (
    START,
    daemon_serving,
    local_daemon,
    running_at,
    running_daemon,
    stop_robot,
)

__all__ = [
    "START",
    "ApiError",
    "Client",
    "JobFailed",
    "daemon_serving",
    "local_daemon",
    "running_at",
    "running_daemon",
    "stop_robot",
]
