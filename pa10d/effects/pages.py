"""The documentation page of an effect, made from its class and nothing else."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from pa10d.effects.base import Effect, ShapeParameter
from pa10d.effects.portrait import Portrait

SCOPES = {
    "joint": "one joint",
    "pair": "a pair of joints",
    "robot": "the robot as a whole",
}
QUESTIONS = {
    "textbook": "in every model from the start",
    "missing": "answers *what is missing?* (the model is fitted again beside it)",
    "changed": "answers *what changed?* (against a model identified earlier, `--frozen`)",
    "chosen": "is never looked for: you choose it (`pa10d add … smooth_map --over …`)",
}

SHARED = "and *what is missing?*, as far as joints that carry the same bodies contradict each other"


def page(kind: Effect, titles: Mapping[str, str], picture: Portrait | None) -> str:
    """Markdown of one effect. titles: id -> title of all effects that may be named; picture:
    what ``<id>.svg`` beside the page shows, if there is one."""
    return "\n\n".join(
        [
            f"# {kind.title}",
            f"`{kind.id}` · sits on {SCOPES[kind.scope]} · {QUESTIONS[kind.question]}"
            + (f"; {SHARED}" if kind.seen_by_shared_bodies else ""),
            kind.meaning,
            "## Equation",
            f"```\n{kind.equation}\n```",
            _notes(kind),
            _parameters(kind),
            "## What it looks like",
            *([_picture(kind, picture)] if picture else []),
            kind.signature,
            *_confounders(kind, titles),
            "## What tells it apart",
            kind.experiment,
            f"Experiment: `pa10d experiment {kind.experiment_kind}`",
            *(["## What to do about it", kind.remedy] if kind.remedy else []),
            "## Source",
            f"{kind.source}\n",
        ]
    )


def index(kinds: Iterable[Effect]) -> str:
    """Markdown of the list of all effects."""
    rows = [
        f"| [{kind.title}]({kind.id}.md) | `{kind.id}` | {SCOPES[kind.scope]} | {kind.signature} |"
        for kind in kinds
    ]
    return "\n".join(
        [
            "# Effects",
            "",
            "What a torque model may contain beside its rigid bodies. These pages are made from",
            "the classes in `pa10d/effects/library` by `scripts/make_effect_pages.py`; to add an",
            "effect of your own, see [add-an-effect.md](../add-an-effect.md).",
            "",
            "| effect | id | sits on | what the error looks like |",
            "|---|---|---|---|",
            *rows,
            "",
            "Beside them stands the [smooth map](smooth_map.md), which you may choose where no",
            "effect explains what is left. It removes the error and explains nothing.",
            "",
        ]
    )


def _notes(kind: Effect) -> str:
    notes = ["τ is the torque that the effect adds, in N·m at the joint side."]
    if kind.sensing:
        notes.append("It acts on the reading of the sensor, not on the arm.")
    if kind.reaches_other_joints:
        notes.append("It shows in the equations of several joints.")
    if kind.uses_model:
        notes.append(
            "τ_load, τ_friction and τ_model are torques of the model so far, not measured ones."
        )
    if kind.remembers:
        notes.append(f"It remembers {kind.remembers}.")
    return " ".join(notes)


def _parameters(kind: Effect) -> str:
    linear = kind.coefficients
    rows = [
        (c.name, c.unit, c.lower, c.upper, "fitted, not reported" if c.nuisance else "linear")
        for c in linear
    ]
    if kind.over:
        first, last = linear[0], linear[-1]
        rows = [(f"{first.name} … {last.name}", first.unit, first.lower, first.upper, "linear")]
    rows += [(s.name, s.unit, s.lower, s.upper, _found_how(kind, s)) for s in kind.shapes]
    return "\n".join(
        [
            "| parameter | unit | from | to | found how |",
            "|---|---|---|---|---|",
            *(
                f"| `{name}` | {unit} | {_bound(low)} | {_bound(high)} | {found} |"
                for name, unit, low, high, found in rows
            ),
        ]
    )


def _found_how(kind: Effect, shape: ShapeParameter) -> str:
    if shape.scale != "choice":
        return "searched, by ratio" if shape.scale == "log" else "searched"
    if kind.over:
        return "from the data"
    means = [f"{value:g} ({words})" for value, words in sorted(shape.says.items())]
    return f"tried: {', '.join(means) or 'both values'}"


def _bound(value: float) -> str:
    return f"{value:g}" if np.isfinite(value) else "no limit"


def _picture(kind: Effect, picture: Portrait) -> str:
    return f"![{kind.title}: signature]({kind.id}.svg)\n\n*{caption(kind, picture)}*"


def caption(kind: Effect, picture: Portrait) -> str:
    """What the picture shows, with the values it was drawn for."""
    example = kind.example
    assert example is not None
    covariance = np.zeros((len(example.coefficients),) * 2)
    reported = kind.values(np.array(example.coefficients), covariance, example.shape, {})
    told = [
        f"{name} = {value.value:.3g}{value.unit_after}{value.meaning}"
        for name, value in reported.items()
    ]
    where = "the torque" if kind.scope == "robot" else "the effect"
    text = f"The PA10: {picture.text}; {where} on {picture.joint}, with {', '.join(told)}."
    if not np.array_equal(picture.left, picture.torque):
        text += " Thin: the effect itself. Bold: what is left of it, and so seen in the error, "
        text += "after the joint's Coulomb and viscous friction are fitted again."
    return text


def _confounders(kind: Effect, titles: Mapping[str, str]) -> list[str]:
    if not kind.confounders:
        return []
    lines = [
        f"- [{titles.get(other, other)}]({other}.md): {why}."
        for other, why in kind.confounders.items()
    ]
    return ["## Easily confused with", "\n".join(lines)]
