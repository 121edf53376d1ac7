"""A mapping that was accepted stays in the profile: the next import needs no ``--map``.

The file is edited as text, one key of it: comments, order and spelling of everything else stay.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path

import yaml

from pa10d.common.errors import UserError
from pa10d.common.yamlfile import read_yaml
from pa10d.profile import Profile, load_profile
from pa10d.profile.load import profile_folders

KEY = "map"


def keep_mapping(profile: Profile, rules: Sequence[str]) -> str:
    """Write the rules before those that the profile has; a sentence that says what was done, empty
    where there was nothing to do."""
    path, known = profile.path, list(profile.map or [])
    fresh = [rule for rule in rules if rule not in known]
    if not fresh:
        return ""
    line = " ".join(f"'{rule}'" for rule in rules)
    if path.suffix == ".urdf":
        return f"a URDF keeps no mapping; 'pa10d profile new {path.name}' makes a file that does"
    if path.parent in profile_folders() or not os.access(path, os.W_OK):
        return f"{path.name} is not yours to write: give --map {line} with each import"
    try:
        replace_key(path, KEY, [*fresh, *known])
    except (UserError, OSError) as error:
        return f"the mapping was not kept: {error}"
    return f"the mapping is kept in {path} ({KEY}:); the next import needs no --map"


def replace_key(path: Path, key: str, values: Sequence[str]) -> None:
    """Give a top-level key of a YAML file a list of texts; all else stays as it is written.

    UserError, and an untouched file, where the result would not be the same profile with that key.
    """
    file = read_yaml(path)
    text = path.read_text(encoding="utf-8-sig")
    written = f"{key}: [" + ", ".join(json.dumps(v, ensure_ascii=False) for v in values) + "]"
    found = next((pair for pair in file.root.value if pair[0].value == key), None)
    if found is None:
        whole = text if text.endswith("\n") else text + "\n"
        edited = f"{whole}{written}\n"
    else:
        begin, end = found[0].start_mark.index, found[1].end_mark.index
        if isinstance(found[1], yaml.SequenceNode) and not found[1].flow_style and found[1].value:
            end = (
                found[1].value[-1].end_mark.index
            )  # the marks of a block end where the next begins
        edited = text[:begin] + written + text[end:]
    draft = path.with_name(f".{path.name}.new.yaml")
    try:
        draft.write_text(edited, encoding="utf-8")
        if read_yaml(draft).data != {**file.data, key: list(values)}:
            raise UserError(f"{path}: {key}: cannot be edited safely; expected a list by hand")
        load_profile(draft)
        os.replace(draft, path)
    finally:
        draft.unlink(missing_ok=True)
