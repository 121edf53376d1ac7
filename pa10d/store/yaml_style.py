"""YAML as people like to read it: short things on one line, long text as it is."""

from __future__ import annotations

from typing import Any

import numpy as np
import yaml

from pa10d.common.yamlfile import EXPONENT


class Flow(dict[str, Any]):
    """A mapping on one line."""


class Row(list[Any]):
    """A list on one line."""


class BlockText(str):
    """Text that keeps its lines."""

    __slots__ = ()


class Dumper(yaml.SafeDumper):
    """Writes people's YAML: short things on one line, long text as it is."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


# the reader takes 1e3 for a number (YAML 1.1 does not), so a model of that name needs quotes
Dumper.add_implicit_resolver(*EXPONENT)
Dumper.add_representer(
    Flow, lambda d, x: d.represent_mapping("tag:yaml.org,2002:map", x.items(), flow_style=True)
)
Dumper.add_representer(
    Row, lambda d, x: d.represent_sequence("tag:yaml.org,2002:seq", x, flow_style=True)
)
Dumper.add_representer(
    BlockText, lambda d, x: d.represent_scalar("tag:yaml.org,2002:str", str(x), style="|")
)


def row(values: Any) -> Row:
    """Numbers on one line."""
    return Row(float(v) for v in values)


def simple(value: Any) -> Any:
    """Arrays and tuples as lists, numbers as Python has them: what YAML can say."""
    if isinstance(value, np.ndarray | np.generic):
        return simple(value.tolist())
    if isinstance(value, dict):
        return {str(key): simple(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        items = [simple(item) for item in value]
        return Row(items) if all(isinstance(i, int | float) for i in items) else items
    if value is None or isinstance(value, bool | int | float | str):
        return value
    return str(value)
