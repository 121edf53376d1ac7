"""The command line: ``pa10d [--data DIR] [--json] COMMAND …``.

Every module in this folder that has a function ``add_commands(commands)`` is a family of
commands; adding a file adds its commands. Modules here are imported at every start, so whatever
takes long to import is imported inside the function that needs it.
"""

from __future__ import annotations

import argparse
import importlib
import pkgutil
import sys
from collections.abc import Sequence
from types import ModuleType

from pa10d.cli.answer import Answer, note, print_answer, print_failure
from pa10d.cli.commands import Subcommands, WrongUsage, current, refuse_unwritable, root_parser
from pa10d.cli.completion import complete
from pa10d.cli.parser import Parser
from pa10d.cli.progress import end_progress
from pa10d.cli.remembered import default_named
from pa10d.cli.streams import for_a_moment, give_up
from pa10d.common.disk import disk_words
from pa10d.common.errors import Unsound, UserError
from pa10d.common.words import as_text

DONE, FAILED, MISUSED, INTERRUPTED = 0, 1, 2, 130


def families() -> list[ModuleType]:
    """All command families, in alphabetical order."""
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    modules = [importlib.import_module(f"{__name__}.{name}") for name in names]
    return [module for module in modules if hasattr(module, "add_commands")]


def whole_parser() -> Parser:
    """``pa10d`` with every command of every family."""
    parser, subparsers = root_parser()
    commands = Subcommands(subparsers)
    for family in families():
        family.add_commands(commands)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; the exit status is 0 done, 1 could not be done, 2 wrong usage."""
    parser = whole_parser()
    complete(parser)
    for argument in sys.argv[1:] if arguments is None else arguments:
        if (shown := as_text(argument)) != argument:
            parser.error(f"found {shown}, expected text in UTF-8: give the file another name")
    options, more = parser.parse_known_args(arguments)
    if more:
        options.parser.error(f"unrecognized arguments: {' '.join(more)}")
    options.data = getattr(options, "data", None)
    options.json = getattr(options, "json", False)
    current.patient = options.patient
    try:
        return _carried_out(options)
    except WrongUsage as error:
        print_failure(str(error), options.json)
        return MISUSED
    except Unsound as error:
        for finding in error.warnings:
            advice = f" → {finding['advice']}" if finding["advice"] else ""
            note(f"warning: {finding['sentence']}{advice}")
        print_failure(f"{error} (--force)", options.json, findings=error.findings)
    except UserError as error:
        print_failure(f"{error}{default_named(options, str(error))}", options.json)
    except KeyboardInterrupt as interrupt:
        why = ": ".join(["interrupted", *map(str, interrupt.args)])
        for_a_moment(lambda: print_failure(why, options.json))
        return INTERRUPTED
    except BrokenPipeError:
        give_up(sys.stdout)
    except OSError as error:
        print_failure(disk_words(error), options.json)
    except MemoryError as error:
        from pa10d.common.shortage import shortage

        print_failure(shortage(error) or str(error), options.json)
    return FAILED


def _carried_out(options: argparse.Namespace) -> int:
    from pa10d.cli.remembered import profile_of, remember

    given = getattr(options, "profile", None)
    options.profile = profile_of(options)
    refuse_unwritable(options)
    try:
        answer: Answer = options.run(options)
    finally:
        end_progress()
    print_answer(answer, options.json, options.answers)
    sys.stdout.flush()
    if answer.status == DONE:
        remember(options, given)
    return answer.status
