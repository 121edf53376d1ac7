"""``python -m pa10d``."""

import sys

from pa10d.cli import main

sys.exit(main())
