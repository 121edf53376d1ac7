"""Write docs/effects: one page and one picture per effect, made from the classes.

    python scripts/make_effect_pages.py [--out FOLDER] [EFFECT ...]

Needs matplotlib (`pip install pa10d[docs]`). Effects of other packages are known by their ids,
too, if they are installed.
"""

from __future__ import annotations

import argparse
import io
import re
import sys
from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np

from pa10d.common.errors import UserError
from pa10d.dynamics import robot_from_profile
from pa10d.effects import all_effects, effect
from pa10d.effects.pages import index, page
from pa10d.effects.portrait import Portrait, portrait
from pa10d.effects.smooth_map import SmoothMap
from pa10d.profile import load_profile

DOCS = Path(__file__).resolve().parent.parent / "docs" / "effects"
POINTS = 320  # per curve
INK, FAINT, ACCENT = "#222222", "#9aa5b1", "#c0392b"
FURTHER = ("#2d6a9f", "#3a8f5c")
STYLE = {
    "svg.fonttype": "none",
    "svg.hashsalt": "pa10d",
    "font.family": "DejaVu Sans",  # comes with matplotlib, so that lengths agree everywhere
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "path.simplify": False,
}


def main(arguments: list[str] | None = None) -> int:
    """Write the pages asked for (default: all, with the index)."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("effects", nargs="*", metavar="EFFECT")
    parser.add_argument("--out", type=Path, default=DOCS, metavar="FOLDER")
    options = parser.parse_args(arguments)
    try:
        library = list(all_effects().values())
        kinds = [effect(name) for name in options.effects] or [*library, effect(SmoothMap.id)]
    except UserError as error:
        print(error, file=sys.stderr)
        return 1
    titles = {kind.id: kind.title for kind in all_effects().values()}
    robot = robot_from_profile(load_profile("pa10-sim"))
    options.out.mkdir(parents=True, exist_ok=True)
    for kind in kinds:
        picture = portrait(kind, robot)
        if picture is not None:
            (options.out / f"{kind.id}.svg").write_text(draw(picture), encoding="utf-8")
        text = page(kind, titles, picture)
        (options.out / f"{kind.id}.md").write_text(text, encoding="utf-8")
    if not options.effects:
        (options.out / "README.md").write_text(index(library), encoding="utf-8")
    return 0


def draw(picture: Portrait) -> str:
    """SVG: the effect against the quantity that brings it out, and over time."""
    with matplotlib.rc_context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 2.7), layout="constrained")
        some = np.unique(np.linspace(0, len(picture.t) - 1, POINTS).astype(int))
        refitted = not np.array_equal(picture.left, picture.torque)
        for axes, x in ((left, picture.x), (right, picture.t)):
            axes.axhline(0.0, color=FAINT, linewidth=0.5)
            if refitted:
                axes.plot(x[some], picture.torque[some], color=ACCENT, linewidth=0.7, alpha=0.6)
            (line,) = axes.plot(x[some], picture.left[some], color=ACCENT, linewidth=1.4)
            line.set_gid(f"signature-{'over-time' if axes is right else 'against'}")
        for (label, torque), colour in zip(picture.others.items(), FURTHER, strict=False):
            right.plot(picture.t[some], torque[some], color=colour, linewidth=0.9, label=label)
        if picture.others:
            line.set_label(picture.joint)
            right.legend(frameon=False, fontsize=8, loc="upper right")
        speed = right.twinx()
        speed.plot(picture.t[some], picture.speed[some], color=FAINT, linewidth=0.7, zorder=0)
        speed.set_ylabel(f"speed of {picture.moving} (rad/s)", color=FAINT)
        speed.tick_params(colors=FAINT)
        left.set(xlabel=picture.x_label, ylabel=f"torque on {picture.joint} (N·m)")
        right.set(xlabel="time (s)")
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": "pa10d"})
        plt.close(figure)
    return _short(text.getvalue())


def _short(svg: str) -> str:
    """Numbers to a tenth of a point, which nobody sees; no rotations by nothing."""
    svg = re.sub(r' transform="rotate\(-0[^"]*"', "", svg)
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"-?\d+\.\d{2,}", lambda n: f"{float(n[0]):.1f}".removesuffix(".0"), svg)
    svg = re.sub(r' d="[^"]*"', lambda path: " " + " ".join(path[0].split()), svg)
    return "\n".join(line.strip() for line in svg.splitlines() if line.strip()) + "\n"


if __name__ == "__main__":
    sys.exit(main())
