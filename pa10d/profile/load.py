"""Where profiles are, and how one is read: every problem in it is told at once, a line each."""

from __future__ import annotations

import os
from pathlib import Path

from pa10d.common.errors import UserError
from pa10d.common.words import did_you_mean
from pa10d.common.yamlfile import YamlFile, read_yaml, validate
from pa10d.profile.profile import Profile


def profile_folders() -> list[Path]:
    """Where profiles are looked for by name: the installed package, or the source tree."""
    here = Path(__file__).resolve().parent.parent
    return [p for p in (here / "profiles", here.parent / "profiles") if p.is_dir()]


def find_profile(name: str | os.PathLike[str]) -> Path:
    """The file behind a path or a bare name such as ``pa10-sim``."""
    path = Path(name)
    if path.is_file():
        return path.resolve()
    for folder in profile_folders():
        candidate = folder / f"{name}.yaml"
        if candidate.is_file():
            return candidate
    known = sorted({p.stem for folder in profile_folders() for p in folder.glob("*.yaml")})
    raise UserError(
        f"{name}: no such profile; expected a YAML or URDF file or one of {', '.join(known)}"
        f"{did_you_mean(str(name), known)}"
    )


def load_profile(name: str | os.PathLike[str]) -> Profile:
    """Read and validate a profile; every problem is one line of the raised UserError.

    A URDF file alone is taken as the profile that only names it.
    """
    path = find_profile(name)
    if path.suffix == ".urdf":
        return Profile(path=path, name=path.stem, urdf=path)
    file = read_yaml(path)
    urdf = file.data.get("urdf")
    if "path" in file.data:
        raise UserError(file.problem(("path",), "an unknown key", "'urdf' for the robot's file"))
    if not isinstance(urdf, str) or not urdf:
        found = "nothing" if urdf is None else repr(urdf)
        raise UserError(file.problem(("urdf",), found, "the path of a URDF file"))
    data = {"name": path.stem, **file.data, "path": path, "urdf": (path.parent / urdf).resolve()}
    profile = validate(Profile, file, data)
    missing = [*_missing_urdf(file, profile, urdf), *_missing_eds(file, profile)]
    if missing:
        raise UserError("\n".join(missing))
    return profile


def _missing_urdf(file: YamlFile, profile: Profile, written: str) -> list[str]:
    if profile.urdf.is_file():
        return []
    wanted = f"an existing file (looked for {profile.urdf})"
    return [file.problem(("urdf",), repr(written), wanted)]


def _missing_eds(file: YamlFile, profile: Profile) -> list[str]:
    return [
        file.problem(("drives", k, "eds"), repr(drive.eds), "an existing file")
        for k, drive in enumerate(profile.drives or [])
        if drive.eds is not None and not (profile.path.parent / drive.eds).is_file()
    ]
