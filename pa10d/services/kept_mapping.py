"""A mapping that was accepted stays in the profile: the next import needs no ``--map``."""

from __future__ import annotations

import os
from collections.abc import Sequence

from pa10d.common.errors import UserError
from pa10d.common.yamlfile import read_yaml
from pa10d.profile import Profile
from pa10d.services.profile_file import not_to_be_written, rewritten
from pa10d.services.tuning.versions import folder_of, write_version
from pa10d.store.folders import locked

KEY = "map"


def keep_mapping(folder: str | os.PathLike[str], profile: Profile, rules: Sequence[str]) -> str:
    """Write the rules before those that the profile has, as a new version of it; a sentence that
    says what was done, empty where there was nothing to do. folder: the data folder."""
    path = profile.path
    if not _fresh(rules, profile.map):
        return ""
    line = " ".join(f"'{rule}'" for rule in rules)
    if path.suffix == ".urdf":
        return f"a URDF keeps no mapping; 'pa10d profile new {path.name}' makes a file that does"
    if not_to_be_written(path):
        return f"{path.name} is not yours to write: give --map {line} with each import"
    try:
        versions = folder_of(folder, path)
        with locked(versions):
            file = read_yaml(path)
            known = file.data.get(KEY)
            data = {**file.data, KEY: [*_fresh(rules, known), *(known or [])]}
            said = [f"mapping: {line}"]
            write_version(versions, said, path, file.text, rewritten(file, data), data)
    except (UserError, OSError) as error:
        return f"the mapping was not kept: {error}"
    return f"the mapping is kept in {path} ({KEY}:); the next import needs no --map"


def _fresh(rules: Sequence[str], known: Sequence[str] | None) -> list[str]:
    return [rule for rule in rules if rule not in (known or [])]
