"""What no effect explains on one joint: on what it depends, where it is, and how to hide it."""

from __future__ import annotations

from pa10d.common.words import rounded
from pa10d.diagnose.outcome.diagnosis import Diagnosis
from pa10d.diagnose.unknown.between_runs import Apart
from pa10d.diagnose.unknown.claims import Unexplained, Unnamed
from pa10d.diagnose.unknown.geometry import OtherGeometry
from pa10d.diagnose.unknown.rubbing import OtherFriction
from pa10d.diagnose.unknown.structure import Structure
from pa10d.effects.smooth_map import EXPLAINS_NOTHING, SmoothMap
from pa10d.figures.diagnosis_texts import CURVE, MAP
from pa10d.figures.plotly import Figure
from pa10d.report.blocks import Block, Plot, Section, Text
from pa10d.report.facts import Command
from pa10d.report.finding_section import Asked
from pa10d.report.verdict import structure_words

INTRO = (
    "Motion predicts this part of the error on data not fitted, so it is no noise; but no effect "
    "of the library looks like it. The map shows where it is."
)


UNNAMED = (
    "This part of the error is more than the noise that this data shows, but neither an effect "
    "of the library nor any one or two quantities of the motion say what it is. Look at it over "
    "time in a comparison; think of what the joint did before, of three or more joints together, "
    "and of what changed during the run."
)


APART = (
    "No one model is right in all of these runs. Look what was changed between them; fit a model "
    "to one side alone, and ask of the other what has changed since."
)

ALL_ALONG = "Fit to motion of both kinds: then it can be told, and named."

MISPLACED = (
    "Bodies and effects bend to a length, an axis or an angle that is wrong. Compare the URDF with "
    "the arm or its drawing, put right what is wrong and identify anew."
)


RUBS = (
    "Let the joint run until nothing changes any more, and record both sides then; or hold out a "
    "run that begins as cold as the fitted one did."
)


STEP = (
    "No one model is right before and after that moment. Look over time, in a comparison, what "
    "happened then; fit a model to runs in which it does not happen."
)


def unexplained_section(
    found: Diagnosis, s: Unexplained, figure: Figure | None, asked: Asked
) -> Section:
    """One joint's map; unless the model was frozen, also the command that removes it."""
    unit = found.model.robot.torque_unit(s.joint)
    if isinstance(s, Apart):
        what = ALL_ALONG if s.all_along else APART if s.at is None else STEP
        said = [Text(found.remaining[s.joint].sentence), Text(what)]
        name = f"Joint {s.joint + 1}: {s.who}"
        return Section(name, list(said), f"{rounded(s.rms, 3)} {unit}")
    if isinstance(s, OtherGeometry):
        said = [Text(found.remaining[s.joint].sentence), Text(MISPLACED)]
        name = f"Joint {s.joint + 1}: the arm may not be as its URDF says"
        return Section(name, list(said), f"{rounded(s.rms, 3)} {unit}")
    if isinstance(s, OtherFriction):
        said = [Text(found.remaining[s.joint].sentence), Text(RUBS)]
        name = f"Joint {s.joint + 1}: friction that is other in the runs held out"
        return Section(name, list(said), f"{rounded(s.rms, 3)} {unit}")
    if isinstance(s, Unnamed) and s.witness == "step":
        said = [Text(found.remaining[s.joint].sentence), Text(STEP)]
        name = f"Joint {s.joint + 1}: a change at one moment"
        return Section(name, list(said), f"{rounded(s.rms, 3)} {unit}")
    if not isinstance(s, Structure) or figure is None:
        said = [Text(found.remaining[s.joint].sentence), Text(UNNAMED)]
        name = f"Joint {s.joint + 1}: what nobody can name"
        return Section(name, list(said), f"{rounded(s.rms, 3)} {unit}")
    reading = MAP if len(s.variables) == 2 else CURVE
    title = f"{rounded(s.rms, 3)} {unit} that no effect explains"
    blocks: list[Block] = [Text(INTRO), Plot(title, figure, reading, structure_words(s) + ".")]
    if not found.frozen:
        blocks.append(_removal(found, s, asked))
    name = f"Joint {s.joint + 1}: what no effect explains"
    return Section(name, blocks, f"{rounded(s.rms, 3)} {unit}")


def _removal(found: Diagnosis, s: Structure, asked: Asked) -> Command:
    count = len(found.findings)
    last = f"{asked.model}.{count}" if count else asked.model
    return Command(
        f"Where the cause cannot be found, a smooth map {EXPLAINS_NOTHING}:",
        [
            f"pa10d add {last} {SmoothMap.id} --joint {s.joint + 1} "
            f"--over '{','.join(s.variables)}' --fit {' '.join(asked.fit)} "
            f"--name {asked.model}.{count + 1}"
        ],
    )
