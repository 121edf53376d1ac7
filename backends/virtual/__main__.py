"""``python -m backends.virtual PROFILE``: the virtual arm as a process of its own."""

from __future__ import annotations

import argparse
import contextlib
import signal
import sys

from backends.arm_lock import only_arm
from backends.virtual.arm import serve
from pa10d.common.errors import UserError
from pa10d.profile import load_profile


def main() -> int:
    """Serve until SIGINT or SIGTERM; says ``ready`` on stdout once the drives are on the bus."""
    parser = argparse.ArgumentParser(prog="python -m backends.virtual", description=__doc__)
    parser.add_argument("profile")
    parser.add_argument("--channel", help="instead of the profile's")
    parser.add_argument("--clock", choices=["simulated", "real"], help="instead of the profile's")
    arguments = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        profile = load_profile(arguments.profile)
        if arguments.channel:
            can = profile.can.model_copy(update={"channel": arguments.channel})
            profile = profile.model_copy(update={"can": can})
        if arguments.clock and profile.simulation:
            simulation = profile.simulation.model_copy(update={"clock": arguments.clock})
            profile = profile.model_copy(update={"simulation": simulation})
        with contextlib.suppress(KeyboardInterrupt), only_arm(profile):
            serve(profile, ready=lambda: print("ready", flush=True))
    except UserError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
