"""``pa10d`` and ``python -m pa10d``: the command line as a process.

Ctrl-C ends it from the first line on; what takes long to import comes later.
"""

import os
import signal


def main() -> None:
    """Run a command and end the process with its status."""
    signal.signal(signal.SIGINT, lambda *_: os._exit(130))
    from pa10d.cli.process import run

    run()


if __name__ == "__main__":
    main()
