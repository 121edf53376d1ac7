"""One colour a joint, in the page and in the plots, that nobody has to guess."""

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from pa10d.figures.plotly import JOINTS

WEB = Path(__file__).parents[2] / "pa10d" / "web"
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
# Machado, Oliveira, Fernandes 2009, table 1, severity 1
EYES = {
    "usual": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
}


def linear(colour: str) -> np.ndarray:
    value = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def lab(rgb: np.ndarray) -> np.ndarray:
    """CIE L*a*b* under D65 of linear RGB."""
    x, y, z = np.cbrt(TO_XYZ @ rgb / [0.9505, 1.0, 1.089])
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("eye", EYES)
def test_no_two_joints_look_alike(eye: str) -> None:
    seen = [lab(np.clip(np.asarray(EYES[eye]) @ linear(one), 0, 1)) for one in JOINTS]
    nearest = min(float(np.linalg.norm(a - b)) for a, b in combinations(seen, 2))
    assert nearest > 10.0  # a difference that is seen without looking for it: 4 to 5


def test_the_page_and_its_plots_agree() -> None:
    listed = re.search(r"COLOURS = \[(.*?)\]", (WEB / "parts" / "scope.js").read_text())
    assert listed is not None
    assert tuple(re.findall(r"#\w{6}", listed.group(1))) == JOINTS
    styled = re.findall(r"--course: (#\w{6})", (WEB / "style" / "parts.css").read_text())
    assert tuple(styled) == JOINTS[: len(styled)]
    assert len(styled) == 7
