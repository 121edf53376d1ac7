"""The bill of materials, CycloneDX: what an installed pa10d consists of, with licences.

    python scripts/sbom.py ENVIRONMENT.json >docs/sbom.json

ENVIRONMENT.json: what ``cyclonedx-py environment`` says of an environment that holds nothing but
the packages of scripts/locked.txt, or the bill as it was. Added here: the JavaScript that lies in
``vendor`` folders.
"""

from __future__ import annotations

import argparse
import hashlib
import json
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
TOOLS = {"pip", "setuptools", "wheel"}
"""Of the environment itself."""


def vendored() -> list[dict[str, Any]]:
    """Components for every ``vendored.json``: name, version, licence and file of each."""
    found = []
    for listed in sorted(ROOT.glob("pa10d/**/vendored.json")):
        for one in json.loads(listed.read_text(encoding="utf-8")):
            content = (listed.parent / one["file"]).read_bytes()
            found.append(
                {
                    "type": "library", "name": one["name"], "version": one["version"],
                    "purl": f"pkg:npm/{one['name'].replace('@', '%40')}@{one['version']}",
                    "bom-ref": f"npm-{one['name']}",
                    "licenses": [{"license": {"id": one["licence"]}}],
                    "hashes": [
                        {"alg": "SHA-256", "content": hashlib.sha256(content).hexdigest()}
                    ],
                }
            )  # fmt: skip
    return found


def bill(environment: dict[str, Any]) -> dict[str, Any]:
    """Without what differs from machine to machine: times, paths, addresses."""
    components = [
        {key: component[key] for key in ("type", "name", "version", "purl", "bom-ref", "licenses")
         if key in component}
        for component in environment["components"]
        if component["name"] not in TOOLS and not component["purl"].startswith("pkg:npm/")
    ]  # fmt: skip
    return {
        "bomFormat": "CycloneDX",
        "specVersion": environment["specVersion"],
        "version": 1,
        "metadata": {"component": {"type": "application", "name": "pa10d"}},
        "components": [*components, *vendored()],
    }


def main() -> None:
    """The bill on standard output."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("environment", type=argparse.FileType(encoding="utf-8"))
    environment = json.load(parser.parse_args().environment)
    print(json.dumps(bill(environment), indent=1, sort_keys=True))


if __name__ == "__main__":
    main()
