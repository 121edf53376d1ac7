"""From runs to a model, and from a model to where and why it fails."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from pa10d.compare import comparison
from pa10d.diagnose import procedure
from pa10d.diagnose.asked.changed import what_changed
from pa10d.face.answers import Comparison, Diagnosis
from pa10d.face.model import Model
from pa10d.face.robot import Robot
from pa10d.face.run import Run
from pa10d.identify import FitOptions
from pa10d.measurement.recording import Recording
from pa10d.services.models import identified

Progress = Callable[[float, str], None]
Cancel = Callable[[], bool]


def identify(
    robot: Robot,
    runs: Sequence[Run],
    cutoff_hz: float | None = None,
    extra: Sequence[str] = (),
    prior: float | None = None,
    given: Mapping[str, tuple[float, float]] | None = None,
    name: str = "model",
    progress: Progress | None = None,
    cancel: Cancel | None = None,
) -> Model:
    """The textbook model: rigid bodies, rotor inertia, Coulomb and viscous friction.

    cutoff_hz: of the low-pass on both sides; default: from the data. extra: ids of further effects,
    on every joint, such as ``"torque_offset"``. prior: % of what is usual for a link, by which its
    body may differ from the URDF's; default: nothing is known of it. given: single parameters
    that you know, as value and standard error (SI): ``{"Fc3": (12.0, 2.0)}``. progress(share done,
    what is being done); cancel: asked now and then, True raises ``Cancelled``.
    """
    stated = tuple((one, *known) for one, known in (given or {}).items())
    options = FitOptions(cutoff_hz, tuple(extra), prior=prior, given=stated)
    made, _ = identified(
        recordings(runs), robot.tree, name=name, options=options, progress=progress, cancel=cancel
    )
    return Model(made)


def compare(
    model: Model,
    runs: Sequence[Run],
    cutoff_hz: float | None = None,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
) -> Comparison:
    """The model's error on runs and where it is. cutoff_hz: default the model's own band."""
    say = heeding(progress, cancel)
    return Comparison(comparison.compare(model.inner, recordings(runs), say, cutoff_hz))


def diagnose(
    model: Model,
    fit: Sequence[Run],
    validate: Sequence[Run] = (),
    frozen: bool = False,
    progress: Progress | None = None,
    cancel: Cancel | None = None,
    own: Sequence[Run] = (),
) -> Diagnosis:
    """Which effect is missing, judged on runs that no fit has seen.

    validate: without it the runs are split into blocks of time. frozen: ask instead what changed
    since the model was identified, without a refit; own: the runs it was identified from, so that
    what it lacks of those is told from what changed.
    """
    if frozen:
        changed = what_changed(
            model.inner, recordings(fit), recordings(validate), recordings(own),
            progress=progress, cancel=cancel,
        )  # fmt: skip
        return Diagnosis(changed, tuple(fit), tuple(validate))
    found = procedure.diagnose(
        model.inner, recordings(fit), recordings(validate), frozen=frozen,
        progress=progress, cancel=cancel,
    )  # fmt: skip
    return Diagnosis(found, tuple(fit), tuple(validate))


def recordings(runs: Sequence[Run]) -> list[Recording]:
    """For the science underneath. One run instead of a list of them is taken as such a list."""
    return [run.recording for run in ([runs] if isinstance(runs, Run) else runs)]


def heeding(progress: Progress | None, cancel: Cancel | None) -> Progress:
    """Progress that also asks whether to go on."""
    from pa10d.common.errors import Cancelled

    def say(share: float, what: str) -> None:
        if cancel is not None and cancel():
            raise Cancelled("cancelled")
        if progress is not None:
            progress(share, what)

    return say
