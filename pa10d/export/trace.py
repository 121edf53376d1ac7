"""Arithmetic that is written down instead of being carried out.

A formula in NumPy is called with arrays of symbols and leaves a graph of operations on single
numbers, in which equal ones are one and known ones are carried out: what a code generator needs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from typing import Any, Union

import numpy as np

Number = Union[float, "Node"]


class NotTraceable(Exception):
    """What in a formula depends on numbers that are not known yet."""


class Node:
    """One operation on nodes and numbers; that of an ``input`` are its name and its joint."""

    __slots__ = ("args", "op")
    __hash__ = object.__hash__

    def __init__(self, op: str, args: tuple[Any, ...]) -> None:
        self.op, self.args = op, args

    def __bool__(self) -> bool:
        raise NotTraceable("a decision that depends on the motion")

    def __float__(self) -> float:
        raise NotTraceable("a number that depends on the motion")

    __index__ = __int__ = __float__

    def __neg__(self) -> Number:
        return apply("negative", self)

    def __abs__(self) -> Number:
        return apply("absolute", self)

    def __add__(self, other: Any) -> Number:
        return apply("add", self, other)

    def __radd__(self, other: Any) -> Number:
        return apply("add", other, self)

    def __sub__(self, other: Any) -> Number:
        return apply("subtract", self, other)

    def __rsub__(self, other: Any) -> Number:
        return apply("subtract", other, self)

    def __mul__(self, other: Any) -> Number:
        return apply("multiply", self, other)

    def __rmul__(self, other: Any) -> Number:
        return apply("multiply", other, self)

    def __truediv__(self, other: Any) -> Number:
        return apply("divide", self, other)

    def __rtruediv__(self, other: Any) -> Number:
        return apply("divide", other, self)

    def __pow__(self, other: Any) -> Number:
        return apply("power", self, other)

    def __rpow__(self, other: Any) -> Number:
        return apply("power", other, self)

    def __gt__(self, other: Any) -> Number:
        return apply("greater", self, other)

    def __ge__(self, other: Any) -> Number:
        return apply("greater_equal", self, other)

    def __lt__(self, other: Any) -> Number:
        return apply("less", self, other)

    def __le__(self, other: Any) -> Number:
        return apply("less_equal", self, other)


KNOWN: dict[str, Callable[..., float]] = {
    "negative": lambda a: -a, "absolute": abs, "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b, "multiply": lambda a, b: a * b, "divide": lambda a, b: a / b,
    "power": lambda a, b: a**b, "sin": math.sin, "cos": math.cos, "tanh": math.tanh,
    "exp": math.exp, "sqrt": math.sqrt, "log": math.log, "arcsin": math.asin,
    "sign": lambda a: float((a > 0) - (a < 0)), "maximum": max, "minimum": min,
    "greater": lambda a, b: float(a > b), "greater_equal": lambda a, b: float(a >= b),
    "less": lambda a, b: float(a < b), "less_equal": lambda a, b: float(a <= b),
    "where": lambda c, a, b: a if c else b,
}  # fmt: skip
"""Operations by the names that NumPy has for them, on numbers that are known."""


def apply(op: str, *args: Any) -> Number:
    """The result, or the node that stands for it; what changes nothing is left out."""
    if op == "clip":
        return apply("minimum", apply("maximum", args[0], args[1]), args[2])
    if op not in KNOWN:
        raise NotTraceable(f"the function {op}")
    plain = tuple(a if isinstance(a, Node) else float(a) for a in args)
    if not any(isinstance(a, Node) for a in plain):
        return KNOWN[op](*plain)
    a, b = plain[0], plain[-1]
    if op == "multiply" and 0.0 in plain:
        return 0.0
    if op in ("multiply", "divide", "power") and _is(b, 1.0):
        return a
    if op == "multiply" and _is(a, 1.0):
        return b
    if op in ("add", "subtract") and _is(b, 0.0):
        return a
    if op == "add" and _is(a, 0.0):
        return b
    if op == "subtract" and _is(a, 0.0):
        return apply("negative", b)
    if op == "multiply" and _is(b, -1.0):
        return apply("negative", a)
    if op == "where" and not isinstance(a, Node):
        return plain[1] if a else plain[2]
    return _node(op, plain)


@cache
def _node(op: str, args: tuple[Any, ...]) -> Node:
    return Node(op, args)


def _is(value: Any, number: float) -> bool:
    return not isinstance(value, Node) and value == number


class Traced(np.ndarray):
    """An array of nodes and numbers on which NumPy writes down what it is asked for."""

    def __array_ufunc__(
        self, ufunc: np.ufunc, method: str, *inputs: Any, out: Any = None, **more: Any
    ) -> Any:
        given = [np.asarray(x).astype(object).view(np.ndarray) for x in inputs]
        if method == "reduce" and ufunc is np.add:
            found = np.add.reduce(given[0], **more)
        elif method != "__call__" or more:
            raise NotTraceable(f"{ufunc.__name__}.{method}")
        elif ufunc is np.matmul:
            found = np.matmul(*given)
        else:
            step = np.frompyfunc(lambda *x: apply(ufunc.__name__, *x), len(given), 1)
            found = step(*given)
        if out is not None:
            out[0].view(np.ndarray)[...] = found
            return out[0]
        return traced(found) if isinstance(found, np.ndarray) else found

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        if function in (np.where, np.clip):
            step = np.frompyfunc(lambda *x: apply(function.__name__, *x), 3, 1)
            return traced(step(*_plain(args)))
        found = function(*_plain(args), **{k: _plain(v) for k, v in kwargs.items()})
        return traced(found) if isinstance(found, np.ndarray) else found


def _plain(x: Any) -> Any:
    if isinstance(x, Traced):
        return x.view(np.ndarray)
    return type(x)(map(_plain, x)) if isinstance(x, list | tuple) else x


def traced(values: Any) -> Any:
    """An array of symbols."""
    return np.asarray(values, dtype=object).view(Traced)


def inputs(name: str, count: int) -> Traced:
    """(1, count) symbols: one sample of a motion."""
    return traced([[_node("input", (name, i)) for i in range(count)]])


def in_order(wanted: Iterable[Any]) -> list[Node]:
    """All nodes that these need, each after those that it needs itself."""
    found: dict[Node, None] = {}
    waiting = [(node, False) for node in wanted if isinstance(node, Node)][::-1]
    while waiting:
        node, ready = waiting.pop()
        if node in found:
            continue
        if ready:
            found[node] = None
        else:
            inner = [a for a in node.args if isinstance(a, Node)]
            waiting += [(node, True), *((a, False) for a in reversed(inner))]
    return list(found)


def inputs_of(wanted: Iterable[Any]) -> set[tuple[str, int]]:
    """Name and joint of every input that these depend on."""
    return {node.args for node in in_order(wanted) if node.op == "input"}


def evaluated(wanted: Any, given: Mapping[str, np.ndarray]) -> np.ndarray:
    """(N,) of one symbol at N samples; given: (N, n) per input's name."""
    values: dict[Node, Any] = {}
    samples = len(next(iter(given.values())))
    for node in in_order([wanted]):
        if node.op == "input":
            name, joint = node.args
            values[node] = given[name][:, joint]
        else:
            inner = (values[a] if isinstance(a, Node) else a for a in node.args)
            values[node] = getattr(np, node.op)(*inner)
    found = values[wanted] if isinstance(wanted, Node) else wanted
    return np.broadcast_to(np.asarray(found, dtype=float), (samples,))


def derivatives(wanted: Sequence[Any], by: Node) -> list[Number]:
    """Of each by one input."""
    slope: dict[Node, Number] = {}
    for node in in_order(wanted):
        inner = [slope[a] if isinstance(a, Node) else 0.0 for a in node.args if node.op != "input"]
        slope[node] = float(node is by) if node.op == "input" else _slope(node, inner)
    return [slope[x] if isinstance(x, Node) else 0.0 for x in wanted]


def _slope(node: Node, inner: list[Number]) -> Number:
    a, b = (*node.args, None)[:2]
    da, db = (*inner, 0.0)[:2]
    rules: dict[str, Callable[[], Any]] = {
        "negative": lambda: apply("negative", da),
        "add": lambda: apply("add", da, db),
        "subtract": lambda: apply("subtract", da, db),
        "multiply": lambda: apply("add", apply("multiply", da, b), apply("multiply", a, db)),
        "sin": lambda: apply("multiply", apply("cos", a), da),
        "cos": lambda: apply("negative", apply("multiply", apply("sin", a), da)),
    }
    if node.op not in rules:
        raise NotTraceable(f"the derivative of {node.op}")
    return rules[node.op]()
