"""A model as a package for controllers of ROS 2: feed-forward efforts by the C export's own code.

The class knows nothing of ROS and is compiled and replayed by the tests; around it stands what a
controller of ``ros2_control`` needs.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from importlib.resources import files
from xml.sax.saxutils import escape

import numpy as np
from numpy.typing import NDArray

from pa10d.export.c_header import c_header, identifier
from pa10d.export.endings import Files
from pa10d.model import TorqueModel

Array = NDArray[np.float64]

TEMPLATES = "ros2_package"  # beside this module: the same in every package, but for @names@


def ros2_control(model: TorqueModel, about: str) -> tuple[Files, list[str]]:
    """The package's files, and one line per effect that they cannot carry."""
    header, lost = c_header(model, about)
    package, robot = package_name(model.name), model.robot
    names = [_quoted(name) for name in robot.joint_names]
    told = "".join(f"- NOT CARRIED: {line}\n" for line in lost) or "- nothing is left out\n"
    words = {
        "package": package,
        "guard": package.upper(),
        "model": identifier(model.name),
        "joints": str(robot.n),
        "names": ", ".join(names),
        "interfaces": ", ".join(_quoted(f"{name}/effort") for name in robot.joint_names),
        "limits": ", ".join(_number(v) for v in robot.effort),
        "yaml_names": f"[{', '.join(names)}]",
        "yaml_ones": _list(np.ones(robot.n)),
        "yaml_zeros": _list(np.zeros(robot.n)),
        "yaml_limits": _list(robot.effort),
        "about": about,
        "about_xml": escape(about),
        "lost": told,
    }
    found = {f"include/{package}/model.h": header}
    for place, template in TEMPLATE_OF.items():
        text = files("pa10d.export").joinpath(TEMPLATES, template).read_text(encoding="utf-8")
        found[place.replace("@package@", package)] = _filled(text, words)
    return found, lost


TEMPLATE_OF = {
    "include/@package@/feed_forward.hpp": "feed_forward.hpp",
    "src/replay.cpp": "replay.cpp",
    "config/@package@.yaml": "parameters.yaml",
    "CMakeLists.txt": "CMakeLists.txt",
    "package.xml": "package.xml",
    "README.md": "README.md",
}


def package_name(model: str) -> str:
    """As ROS wants it: small letters, digits, single underscores."""
    plain = re.sub(r"_+", "_", identifier(model).lower()).strip("_")
    return f"{plain}_feed_forward"


def _filled(text: str, words: dict[str, str]) -> str:
    return re.sub(r"@(\w+)@", lambda found: words[found[1]], text)


def _quoted(text: str) -> str:
    """As C++ and YAML both read it."""
    return json.dumps(text, ensure_ascii=False)


def _number(value: float) -> str:
    return repr(float(value)) if np.isfinite(value) else "std::numeric_limits<double>::infinity()"


def _list(values: Array | Sequence[float]) -> str:
    return "[" + ", ".join(".inf" if np.isinf(v) else repr(float(v)) for v in values) + "]"
