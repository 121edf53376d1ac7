"""What an effect is worth to a controller: an arm hides it, is investigated, and is then moved by
each control law, with the model before and after."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pa10d.common.errors import UserError
from pa10d.common.jsonable import JsonObject
from pa10d.demo.bench import Bench
from pa10d.demo.hidden import Hidden
from pa10d.demo.story import chapter


def refuse_what_comes_later(asked: str, hidden: Hidden) -> None:
    """Say so where an effect is none that an arm is born with."""
    if hidden.changes:
        raise UserError(
            f"--hide {asked}: it happens to an arm that was good before; expected an effect that "
            "is there from the start, such as stribeck:4"
        )


def worth(
    bench: Bench,
    hidden: Hidden,
    motion: Mapping[str, Any],
    tell: Callable[[str], None],
    progress: Callable[[float, str], None],
) -> JsonObject:
    """The table of ``Client.track``, with ``hidden`` and ``found``; motion: {kind, parameters}.

    Where the diagnosis finds nothing there is one model, and nothing to compare it with."""
    tell("2. It is moved and investigated: the textbook model, and what it lacks.")
    found = chapter(bench.client, tell, progress)
    models = list(dict.fromkeys([found["models"][0], found["models"][-1]]))
    tell(f"3. The same motion ({motion['kind']}) by every control law, with each model.")
    table = bench.client.track(models, motion["kind"], motion["parameters"], progress)
    return {
        **table,
        "hidden": hidden.name,
        "hidden_joints": list(hidden.joints),
        "found": [{"effect": f["effect"], "joints": f["joints"]} for f in found["findings"]],
    }
