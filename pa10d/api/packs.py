"""Modules of the page in packs: a script and whatever it imports as one part.

On a slow link every part costs a round of its own, and forty small files compress badly. Sources
stay native modules, one idea each; a pack wraps each of them in a function, in the order of need,
and runs it unless another pack has done so. What is vendored stays a module by itself.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Callable

MAIN = "main.js"
FOLDER = "packs/"
VENDORED = "vendor/"
_IMPORT = re.compile(r'^import (\{[^}]*\}) from "(\.[^"]+)";\n', re.MULTILINE)
_EXPORT = re.compile(r"^export ((?:async function|function|class|const) (\w+))", re.MULTILINE)
_LATER = re.compile(r"\bimport\(([\"`])(\.[^\"`]+)\1\)")
_REMARK = re.compile(r"^ *(?://.*|/\*\*(?:.|\n)*?\*/)\n", re.MULTILINE)

Read = Callable[[str], str]


def pack(script: str, read: Read) -> str:
    """The pack of a script, a module with the same exports. read: a module's text by its name."""
    brought = [] if script == MAIN else _needed(MAIN, read)
    names = [name for name in _needed(script, read) if name not in brought]
    foreign = sorted({one for name in names for one, _ in _imports(name, read(name))})
    foreign = [one for one in foreign if one.startswith(VENDORED)]
    root = "../" * (FOLDER + script).count("/")
    return "\n".join([
        *(f'import * as foreign{n} from "{root}{one}";' for n, one in enumerate(foreign)),
        "const $known = (globalThis.pa10dModules ??= new Map());",
        *(f'$known.set("{one}", foreign{n});' for n, one in enumerate(foreign)),
        f'const $at = (name) => new URL(`{root}${{name}}`, import.meta.url).href;',
        "const $add = (name, make) => $known.has(name) || $known.set(name, make());",
        *(_wrapped(name, read(name)) for name in names),
        *_given_on(script, read(script)),
        "",
    ])  # fmt: skip


def _needed(script: str, read: Read) -> list[str]:
    """A script and every module of ours that it imports, each after those it needs itself."""
    found: list[str] = []
    for name, _ in _imports(script, read(script)):
        if not name.startswith(VENDORED):
            found += [one for one in _needed(name, read) if one not in found]
    return [*found, script]


def _imports(name: str, text: str) -> list[tuple[str, str]]:
    """(module, names taken from it) of every import that stands at a module's head."""
    return [(_resolved(name, said), taken) for taken, said in _IMPORT.findall(text)]


def _resolved(name: str, said: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(name), said))


def _wrapped(name: str, text: str) -> str:
    def taken(found: re.Match[str]) -> str:
        names = found[1].replace(" as ", ": ")
        return f'const {names} = $known.get("{_resolved(name, found[2])}");\n'

    def later(found: re.Match[str]) -> str:
        quote, target = found[1], _resolved(name, found[2])
        folder = "" if target.startswith(VENDORED) else FOLDER
        return f"import($at({quote}{folder}{target}{quote}))"

    body = _EXPORT.sub(r"\1", _LATER.sub(later, _IMPORT.sub(taken, _REMARK.sub("", text))))
    body = body.replace("import.meta.url", f'$at("{name}")')
    given = ", ".join(_exports(text))
    return f'$add("{name}", () => {{\n{body}return {{ {given} }};\n}});'


def _exports(text: str) -> list[str]:
    return [name for _, name in _EXPORT.findall(text)]


def _given_on(script: str, text: str) -> list[str]:
    names = ", ".join(_exports(text))
    return [f'export const {{ {names} }} = $known.get("{script}");'] if names else []
