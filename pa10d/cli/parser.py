"""How the command line is read: what was meant by a misspelt word, examples in every --help."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator, Sequence
from typing import Any, NoReturn

from pa10d.common.words import did_you_mean


class Parser(argparse.ArgumentParser):
    """Says what may have been meant; shows examples as they were written."""

    def __init__(self, *, examples: Sequence[str] = (), **settings: Any) -> None:
        """examples: whole command lines, shown below the options."""
        if examples:
            settings["epilog"] = "\n".join(["examples:", *(f"  {line}" for line in examples)])
        super().__init__(
            formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False, **settings
        )
        self.examples = tuple(examples)
        self._negative_number_matcher = re.compile(r"-\.?\d")  # -1,0,0 is no option, either

    def leaves(self) -> Iterator[Parser]:
        """The commands below, or itself, that have none below them."""
        below = [a for a in self._actions if isinstance(a, argparse._SubParsersAction)]
        if not below:
            yield self
        for action in below:
            for each in action.choices.values():
                yield from each.leaves()

    def error(self, message: str) -> NoReturn:
        """Wrong usage, status 2, with what may have been meant."""
        super().error(message + self._meant(message))

    def _meant(self, message: str) -> str:
        if wrong := re.search(r"invalid choice: '([^']*)'", message):
            choices = [action.choices for action in self._actions if action.choices]
            return did_you_mean(wrong[1], [str(c) for several in choices for c in several])
        if wrong := re.search(r"unrecognized arguments: (--[\w-]+)", message):
            return did_you_mean(wrong[1], self._option_string_actions)
        return ""
