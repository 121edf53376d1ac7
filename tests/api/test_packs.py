"""The page's modules as they go out: a script and all it needs as one part, each run once."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest

from pa10d.api.assets import WEB, Assets
from pa10d.api.packs import MAIN, pack

MODULES = {
    "main.js": 'import { say } from "./base/words.js";\nsay("main");\n',
    "base/words.js": "// said aloud\nexport const said = [];\n"
    "export function say(word) { said.push(word); }\nsay('words');\n",
    "parts/box.js": 'import { say as tell } from "../base/words.js";\n'
    "tell('box');\nexport class Box {}\n",
    "sections/one.js": 'import { Box } from "../parts/box.js";\n'
    'import { said } from "../base/words.js";\nexport const mount = () => [said, Box.name];\n',
    "sections/two.js": 'import { Box } from "../parts/box.js";\n'
    'import { one } from "../vendor/lib.js";\n'
    "export async function mount() { return [Box, one]; }\n",
}


def own() -> list[str]:
    names = (path.relative_to(WEB).as_posix() for path in sorted(WEB.rglob("*.js")))
    return [name for name in names if not name.startswith("vendor/")]


def test_what_main_brings_is_not_brought_again():
    assert '$add("base/words.js"' in pack(MAIN, MODULES.__getitem__)
    section = pack("sections/one.js", MODULES.__getitem__)
    assert re.findall(r'\$add\("([^"]+)"', section) == ["parts/box.js", "sections/one.js"]
    assert 'export const { mount } = $known.get("sections/one.js");' in section
    assert "said aloud" not in pack(MAIN, MODULES.__getitem__)


def test_what_is_vendored_stays_a_module(tmp_path):
    section = pack("sections/two.js", MODULES.__getitem__)
    assert section.startswith('import * as foreign0 from "../../vendor/lib.js";\n')


def test_packs_say_what_the_modules_say(tmp_path):
    """Run by an engine: modules of two packs run once, in the order of need, and share values."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node here; the page's own tests run the packs in a browser")
    for script in ("main.js", "sections/one.js", "sections/two.js"):
        path = tmp_path / "packs" / script
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(pack(script, MODULES.__getitem__))
    (tmp_path / "vendor").mkdir()
    (tmp_path / "vendor/lib.js").write_text("export const one = 1;\n")
    (tmp_path / "package.json").write_text('{"type": "module"}')
    asked = tmp_path / "asked.js"
    asked.write_text(
        "import './packs/main.js';\nconst one = await import('./packs/sections/one.js');\n"
        "const two = await import('./packs/sections/two.js');\n"
        "const [Box, n] = await two.mount();\n"
        "console.log(JSON.stringify([...one.mount(), Box.name, n]));\n"
    )
    said = subprocess.run([node, asked], capture_output=True, text=True, check=True, timeout=120)
    assert said.stdout == '[["words","main","box"],"Box","Box",1]\n'


@pytest.mark.parametrize("name", own())
def test_every_module_has_the_form_that_is_packed(name):
    """No export and no import is left where a function stands around it."""
    found = Assets().get(f"packs/{name}")
    if name == "stop.js":  # a plain script, for itself
        return
    assert found is not None
    text = found.plain.decode()
    inside = text[text.index("const $add") :].splitlines()
    inside = [line for line in inside if not line.startswith("export const { ")]
    assert not [line for line in inside if line.startswith(("import ", "export "))]
    assert "import.meta" not in "\n".join(inside)


@pytest.mark.parametrize("name", ["packs/vendor/three.js", "packs/icon.svg", "packs/none.js"])
def test_only_our_modules_are_packed(name):
    assert Assets().get(name) is None
