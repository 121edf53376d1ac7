"""The command line: ``pa10d [--data DIR] [--json] COMMAND …``.

Every module in this folder that has a function ``add_commands(commands)`` is a family of
commands; adding a file adds its commands. Modules here are imported at every start, so whatever
takes long to import is imported inside the function that needs it.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
import sys
from collections.abc import Sequence
from types import ModuleType

from pa10d.cli.answer import print_answer, print_failure
from pa10d.cli.commands import Commands, current, root_parser
from pa10d.common.errors import Unsound, UserError

DONE, FAILED, INTERRUPTED = 0, 1, 130


def families() -> list[ModuleType]:
    """All command families, in alphabetical order."""
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    modules = [importlib.import_module(f"{__name__}.{name}") for name in names]
    return [module for module in modules if hasattr(module, "add_commands")]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the exit status is 0 done, 1 could not be done, 2 wrong usage."""
    parser, subparsers = root_parser()
    commands = Commands(subparsers)
    for family in families():
        family.add_commands(commands)
    options = parser.parse_args(arguments)
    options.data = getattr(options, "data", None)
    options.json = getattr(options, "json", False)
    current.patient = options.patient
    try:
        answer = options.run(options)
        print_answer(answer, options.json, options.kind)
        sys.stdout.flush()
        return answer.status
    except Unsound as error:
        print_failure(f"{error} (--force)", options.json, findings=error.findings)
    except UserError as error:
        print_failure(str(error), options.json)
    except KeyboardInterrupt as interrupt:
        print_failure(": ".join(["interrupted", *map(str, interrupt.args)]), options.json)
        return INTERRUPTED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        print_failure(f"{where}{error.strerror or error}", options.json)
    return FAILED
