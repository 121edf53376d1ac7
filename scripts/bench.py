#!/usr/bin/env python3
"""Measure what the README quotes: python scripts/bench.py KIND [--json] [options of the kind].

A kind is a module scripts/bench_KIND.py with ``run(**options) -> dict`` and
``sentences(dict) -> str``; options are the keyword arguments of ``run``.
"""

from __future__ import annotations

import argparse
import importlib
import inspect
import json
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
KINDS = ("loop", "simulate", "identify", "excitation", "diagnose", "real", "long")


def main(arguments: list[str] | None = None) -> int:
    sys.path[:0] = [str(HERE), str(HERE.parent)]
    parser = argparse.ArgumentParser(prog="bench.py", description=__doc__)
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")
    given, rest = parser.parse_known_args(arguments)
    if not (HERE / f"bench_{given.kind}.py").is_file():
        print(f"bench.py {given.kind}: scripts/bench_{given.kind}.py is missing", file=sys.stderr)
        return 1
    module = importlib.import_module(f"bench_{given.kind}")
    figures = module.run(**_options(module.run, given.kind, rest))
    print(json.dumps(figures) if given.json else module.sentences(figures))
    return 0


def _options(function: Any, kind: str, rest: list[str]) -> dict[str, Any]:
    """The kind's own options, from the keyword arguments of its ``run``."""
    parser = argparse.ArgumentParser(prog=f"bench.py {kind}")
    for name, parameter in inspect.signature(function).parameters.items():
        kind_of = type(parameter.default) if parameter.default is not None else str
        parser.add_argument(f"--{name.replace('_', '-')}", type=kind_of, default=parameter.default)
    return vars(parser.parse_args(rest))


if __name__ == "__main__":
    raise SystemExit(main())
