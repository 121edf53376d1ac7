"""Pages and pictures in docs/effects are those that the classes make now."""

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest
from effect_motions import pa10, rms

from pa10d.effects import all_effects, effect
from pa10d.effects.pages import index, page
from pa10d.effects.portrait import portrait

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs" / "effects"
LIBRARY = {k: v for k, v in all_effects().items() if type(v).__module__.startswith("pa10d.")}
EFFECTS = LIBRARY | {"smooth_map": effect("smooth_map")}
TITLES = {k: v.title for k, v in EFFECTS.items()}
every = pytest.mark.parametrize("name", sorted(EFFECTS))
STALE = "stale: run python scripts/make_effect_pages.py"


@every
def test_page_is_up_to_date(name):
    kind = EFFECTS[name]
    text = (DOCS / f"{name}.md").read_text(encoding="utf-8")
    assert text == page(kind, TITLES, portrait(kind, pa10())), STALE


def test_list_is_up_to_date_and_nothing_is_left_over():
    text = (DOCS / "README.md").read_text(encoding="utf-8")
    assert text == index(LIBRARY.values()), STALE
    pages = {p.stem for p in DOCS.glob("*.md")} - {"README"}
    assert pages == {p.stem for p in DOCS.glob("*.svg")} == set(EFFECTS)


@every
def test_page_says_all_and_links_lead_somewhere(name):
    kind = EFFECTS[name]
    text = (DOCS / f"{name}.md").read_text(encoding="utf-8")
    for said in (kind.title, kind.id, kind.equation, kind.meaning, kind.signature, kind.experiment):
        assert said in text
    for said in (kind.remedy, kind.source, *kind.confounders.values(), kind.experiment_kind):
        assert said in text
    for c in (*(() if kind.over else kind.coefficients), *kind.shapes):
        assert f"| `{c.name}` | {c.unit} |" in text
    for target in re.findall(r"\]\(([^)]+)\)", text):
        assert (DOCS / target).is_file(), target


@every
def test_portrait_shows_the_effect(name):
    kind = EFFECTS[name]
    drawn = portrait(kind, pa10())
    assert len(drawn.t) == len(drawn.x) == len(drawn.left) == len(drawn.torque)
    assert np.isfinite(drawn.left).all()
    # something to see, and more than a fit of friction leaves of friction
    assert rms(drawn.torque) > 0.05
    assert rms(drawn.left) > 0.1 * rms(drawn.torque)
    assert np.ptp(drawn.x) > 0


@pytest.mark.by_default("spring")
@every
def test_picture_is_up_to_date_and_small(name):
    pytest.importorskip("matplotlib", reason="matplotlib draws the pictures; pip install .[docs]")
    spec = importlib.util.spec_from_file_location("pages", ROOT / "scripts/make_effect_pages.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    path = DOCS / f"{name}.svg"
    assert path.stat().st_size < 60_000
    stored, made = path.read_text(encoding="utf-8"), script.draw(portrait(EFFECTS[name], pa10()))
    for curve in ("signature-against", "signature-over-time"):
        assert curve_of(made, curve) == pytest.approx(curve_of(stored, curve), abs=2.0), STALE


def curve_of(svg: str, name: str) -> np.ndarray:
    """Points of one curve, in points of the page."""
    (path,) = re.findall(rf'<g id="{name}">\s*<path d="([^"]*)"', svg)
    points = np.array([float(x) for x in re.findall(r"-?\d+(?:\.\d+)?", path)])
    assert len(points) > 200
    return points
