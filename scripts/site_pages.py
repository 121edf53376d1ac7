"""Pages of the site that are made from the program itself; called by mkdocs.

The README is the first page; commands, library and documents are as the code says they are.
"""

from __future__ import annotations

import importlib
import inspect
import json
import re
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
STATUSES = """
| exit status | means |
|---|---|
| 0 | done |
| 1 | it could not be done; one line says why (with `--json` a document `{"error": …}`) |
| 2 | wrong usage |
| 130 | interrupted |
"""


def on_files(files: Any, config: Any) -> Any:
    """mkdocs' hook: what is generated joins what is written."""
    from mkdocs.structure.files import File

    for name, content in pages().items():
        files.append(File.generated(config, name, content=content))
    return files


def pages() -> dict[str, str]:
    """Name -> Markdown."""
    return {
        "index.md": first_page(),
        "reference/commands.md": commands(),
        "reference/library.md": library(),
        "reference/documents.md": documents(),
    }


def first_page() -> str:
    """The README, seen from inside the docs."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    return re.sub(r"\]\(docs/", "](", text)


def commands() -> str:
    """Every command with its options and examples."""
    from pa10d.cli import whole_parser

    parts = ["# Commands", STATUSES.strip(), "`pa10d schema NAME` prints what `--json` holds."]
    for leaf in whole_parser().leaves():
        parts += [f"## {leaf.prog}", f"```text\n{leaf.format_help().strip()}\n```"]
    return "\n\n".join(parts) + "\n"


def library() -> str:
    """Functions and values of ``import pa10d``, with what they say of themselves."""
    import pa10d

    known = {name: spoken_for(getattr(pa10d, name)) for name in pa10d.__all__}
    parts = ["# Library", inspect.getdoc(pa10d) or ""]
    for name, kind in known.items():
        parts += [f"## {name}", described(f"pa10d.{name}", kind)]
        if inspect.isclass(kind):
            members = [m for m in vars(kind) if not m.startswith("_")]
            parts += [described(f"{name}.{m}", getattr(kind, m)) for m in members]
    return "\n\n".join(parts) + "\n"


def spoken_for(thing: Any) -> Any:
    """The function behind a room that answers when called."""
    if not hasattr(thing, "_called"):
        return thing
    module, _, name = thing._called.partition(":")
    return getattr(importlib.import_module(module), name)


def described(name: str, thing: Any) -> str:
    """Signature, where there is one, and docstring."""
    thing = getattr(thing, "fget", thing)
    function = inspect.isfunction(thing)
    head = f"{name}{inspect.signature(thing)}".replace("'", "") if function else name
    return f"```python\n{head}\n```\n\n```text\n{inspect.getdoc(thing) or ''}\n```"


def documents() -> str:
    """Every JSON document's fields."""
    from pa10d.services.documents import SCHEMAS

    parts = ["# JSON documents", "Every document names its `schema`, `pa10d/<name>/<version>`."]
    for name in sorted(SCHEMAS):
        schema = json.dumps(SCHEMAS[name].model_json_schema(), indent=1, ensure_ascii=False)
        parts += [f"## {name}", f"```json\n{schema}\n```"]
    return "\n\n".join(parts) + "\n"
