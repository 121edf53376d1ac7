"""``pa10d effect …``: the library, an effect of one's own, and whether it conforms."""

from __future__ import annotations

import argparse
from pathlib import Path

from pa10d.cli.answer import Answer, note, table
from pa10d.cli.commands import Subcommands, WrongUsage


def add_commands(commands: Subcommands) -> None:
    """The family ``effect``."""
    effects = commands.group("effect", "effects: list, new, check, page")
    effects.add(
        "list",
        list_,
        "what a torque model may contain beside its rigid bodies",
        examples=("pa10d effect list",),
    )
    parser = effects.add(
        "new",
        new,
        "a package for an effect of your own: class, test and page",
        examples=("pa10d effect new belt_slip --out belt_slip",),
    )
    parser.add_argument("name", metavar="NAME", help="its id: small letters and underscores")
    parser.add_argument("--out", type=Path, metavar="DIR", help="default: ./NAME")
    parser = effects.add(
        "check",
        check,
        "does an effect keep what models rely on?",
        examples=(
            "pa10d effect check",
            "pa10d effect check belt_slip --hide",
        ),
    )
    parser.add_argument("ids", metavar="ID", nargs="*", help="default: all that are installed")
    parser.add_argument(
        "--hide", action="store_true",
        help="also hide it in a simulated arm and look for it again (a minute each)",
    )  # fmt: skip
    parser.add_argument(
        "--draws", type=int, default=20, metavar="N",
        help="random shapes and motions for each check (default: 20)",
    )  # fmt: skip
    parser = effects.add(
        "page",
        page,
        "an effect's documentation page, made from its class",
        examples=("pa10d effect page stribeck",),
    )
    parser.add_argument("effect", metavar="ID")


def list_(options: argparse.Namespace) -> Answer:
    """``effect list``."""
    from pa10d.effects import all_effects

    kinds = list(all_effects().values())
    document = [
        {"id": k.id, "title": k.title, "scope": k.scope, "question": k.question,
         "equation": k.equation}
        for k in kinds
    ]  # fmt: skip
    rows = [[k.id, k.title, k.scope, k.equation] for k in kinds]
    return Answer(document, table(["id", "effect", "sits on", "equation"], rows))


def new(options: argparse.Namespace) -> Answer:
    """``effect new``."""
    from pa10d.effect_kit.scaffold import scaffold

    folder = options.out or Path(options.name)
    files = scaffold(options.name, folder)
    lines = [
        *map(str, files),
        f"next: edit {files[0].name}, then pip install {folder} and pa10d effect check "
        f"{options.name}",
    ]
    return Answer({"id": options.name, "files": [str(f) for f in files]}, "\n".join(lines))


def check(options: argparse.Namespace) -> Answer:
    """``effect check``: status 1 where one of them does not conform."""
    from pa10d.effect_kit import check as verdicts
    from pa10d.effects import all_effects, effect

    if options.draws < 1:
        raise WrongUsage(f"--draws {options.draws}: expected at least 1")
    kinds = [effect(name) for name in options.ids] or list(all_effects().values())
    found, lines = [], []
    for kind in kinds:
        note(f"checking {kind.id}")
        seen = verdicts(kind, options.draws, options.hide)
        found.append(
            {"id": kind.id, "passed": all(v.passed for v in seen), "checks": list(map(vars, seen))}
        )
        lines += [f"{kind.id}: {v.check}: {v.says}" for v in seen if not v.passed]
        if found[-1]["passed"]:
            lines.append(f"{kind.id}: conforms ({', '.join(v.check for v in seen)})")
    good = all(entry["passed"] for entry in found)
    return Answer({"passed": good, "effects": found}, "\n".join(lines), 0 if good else 1)


def page(options: argparse.Namespace) -> Answer:
    """``effect page``: Markdown on stdout."""
    from pa10d.effects import all_effects, effect
    from pa10d.effects.pages import page as written

    kind = effect(options.effect)
    text = written(kind, {k.id: k.title for k in all_effects().values()}, None)
    return Answer({"id": kind.id, "markdown": text}, text.rstrip())
