"""Numbers and lists as a sentence has them."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Sequence


def percent(share: float) -> str:
    """``38 %``; nothing is ever gone to 100 %."""
    return "more than 99 %" if share > 0.99 else f"{100 * share:.0f} %"


def times(ratio: float) -> str:
    """``1.8 times``, ``24 times``, ``5000 times``: as many digits as say something."""
    return f"{ratio:.1f} times" if ratio < 9.95 else f"{float(f'{ratio:.2g}'):.0f} times"


def rounded(value: float, digits: int) -> str:
    """``350`` and ``0.0123``: so many digits that say something, and no power of ten for what a
    large arm measures in plain numbers."""
    short = f"{value:.{digits}g}"
    return f"{float(short):.0f}" if 10.0**digits <= abs(float(short)) < 1e7 else short


def times_noise(rms: float, floor: float) -> str:
    """``1.8 × noise``, or that the noise is not known."""
    return f"{rms / floor:.1f} × noise" if floor > 0 else "noise not known"


def counted(count: int, what: str) -> str:
    """``1 run``, ``3 runs``."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def listed(words: Sequence[str], last: str = "and") -> str:
    """``a, b and c``."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"


def joint_words(joints: Iterable[int]) -> str:
    """``joint 3``, ``joints 1 and 4``, ``joints 1 to 7``, of 0-based numbers in order."""
    numbers = [int(j) + 1 for j in joints]
    if len(numbers) > 2 and numbers[-1] - numbers[0] == len(numbers) - 1:
        return f"joints {numbers[0]} to {numbers[-1]}"
    return f"joint{'s' if len(numbers) > 1 else ''} {listed([str(one) for one in numbers])}"


def of_a_slide(said: str) -> str:
    """What is said of a joint that turns, of one that slides: m for rad, N for N·m, kg for kg·m²,
    cycles in a metre for those of a turn."""
    for turns, slides in (("kg·m²", "kg"), ("N·m", "N"), ("cycles/rev", "1/m")):
        said = said.replace(turns, slides)
    return re.sub(r"\brad\b", "m", said)


def sentence(text: str) -> str:
    """The same with a capital and a full stop: several notes stand one after the other."""
    return f"{text[:1].upper()}{text[1:]}{'' if text.endswith(('.', '!', '?')) else '.'}"


def from_one(last: int) -> str:
    """``1 to 7``, ``1, the only one``: the numbers that there are."""
    return f"1 to {last}" if last > 1 else "1, the only one"


def did_you_mean(found: str, known: Iterable[str]) -> str:
    """``; did you mean diagnose?`` where one of ``known`` is like ``found``, else nothing."""
    close = difflib.get_close_matches(found, list(known), n=1)
    return f"; did you mean {close[0]}?" if close else ""


def as_text(name: str) -> str:
    """What a file is called, also where its bytes are no text: neither JSON nor a terminal takes
    the marks that Python has for those."""
    return name.encode("utf-8", "backslashreplace").decode()
