"""What a person should know in front of each plot: how to read it, and what to do next."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Reading:
    """Two short texts for one kind of plot; the long version is docs/reading-the-plots.md. noise:
    how the noise is marked in it, where it is known."""

    read: str
    then: str
    noise: str = ""

    def told(self, known: bool) -> Reading:
        """With what is said of the noise, or that it is not known and nothing marks it."""
        noise = self.noise and (self.noise if known else NOT_KNOWN)
        return Reading(f"{self.read} {noise}".strip(), self.then)


NOT_KNOWN = (
    "The noise is not known from these runs, and nothing marks it here: record one motion twice."
)


_STEPS = (
    "Each step is a version of the model, each line a joint, judged on the same runs. Down is "
    "better."
)
_NO_GAIN = (
    "A step that does not go down bought nothing: go back to its parent. A line that goes up at "
    "one joint while others fall is a wrong explanation."
)

TEXTS = {
    "overview": Reading(
        "Each bar is a joint's error divided by the noise that its sensors leave in the same band. "
        "1 (dashed) is a perfect model; 2 means that as much again is unexplained. A joint without "
        "a bar is one whose noise is not known.",
        "Look at the tallest joints first. Below 1.2 there is little left to find; a bar below 1 "
        "means that the noise floor is estimated too high, not that the model is too good.",
    ),
    "overview_of_range": Reading(
        "The noise of no joint is known from these runs. Each bar is a joint's error divided by "
        "the range of its measured torque, from the smallest to the largest.",
        "Record one motion twice: what differs is noise, and then it can be said how much of a bar "
        "is the model's. Until then look at the tallest joints first, and at the shapes below.",
    ),
    "time": Reading(
        "Above, the measured torque with the model's over it; below, their difference. Both are "
        "low-passed alike. Grey: not judged, because the joint stands still (friction at rest is "
        "indeterminate), the filter has not settled, or the stretch is left out.",
        "Spikes at reversals point to friction, a slow offset to gravity, a payload or a sensor "
        "bias, growth with time to warming up, bursts at one speed to a resonance. Choose another "
        "run to see whether it repeats.",
        "Green: two standard deviations of the noise.",
    ),
    "maps": Reading(
        "The same residual against position, velocity, load and time. A flat orange line is what "
        "noise looks like; any shape of it is torque that the model misses. Red: ranges in which "
        "the squared error piles up.",
        "A step or bump at zero velocity is friction, a slope against position a spring or "
        "gravity, a fan that opens with load friction under load or a wrong torque constant, a "
        "kink beyond one angle a contact. A diagnosis names and tests it.",
        "Green: two standard deviations of the noise, within which the line should lie.",
    ),
    "spectra": Reading(
        "The order spectrum is the residual in cycles per revolution of the joint: cogging, gear "
        "mesh and bearings make a line there at every speed. The frequency spectrum is in hertz: "
        "resonances and electrical noise make a line there. The green dashes are the level that "
        "noise does not pass (orders) and the cut-off of the fit (hertz).",
        "A line among the orders: multiply by the gear ratio to see which part turns so often, and "
        "suspect torque ripple. A hump in hertz only: record a chirp and suspect an elastic "
        "joint, or lower the cut-off.",
    ),
    "memory": Reading(
        "How much the residual resembles itself a moment later. White noise stays within the green "
        "band but for one point in twenty; a slow decay means that something slow is unexplained, "
        "or that the noise itself is coloured.",
        "If the maps above are flat although this one is not, the rest is coloured noise, and "
        "a better model will not remove it. If they are not flat, look for the effect first.",
    ),
    "staircase": Reading(
        _STEPS,
        _NO_GAIN,
        "Errors are divided by the noise, the least that is seen through any version: 1 (dashed) "
        "is as good as it gets.",
    ),
    "staircase_in_units": Reading(
        f"{_STEPS} The noise is not known of every joint from these runs, so errors stand in their "
        "units and nothing marks how low a line can come: record one motion twice.",
        _NO_GAIN,
    ),
    "versus": Reading(
        "For every joint the error of both models on the same runs.",
        "The better model is lower everywhere. Lower at one joint and higher at another is no "
        "gain: look at both in Compare.",
        "Beside them the noise (green), which no model can go below.",
    ),
    "evidence": Reading(
        "Left, the residual without the effect and, over it, the torque that the effect adds. "
        "Right, what is left with it. All samples are from runs that the fit has not seen.",
        "Believe it if the orange follows the blue everywhere and the right side is flat. If only "
        "part of it follows, another effect may fit better: see what it is confused with.",
    ),
}
