"""Elementary functions that take floats, numpy arrays and UFL expressions alike.

The closures are written once with these, so that the solver (UFL), the post-processing (numpy) and
the tests (floats) share one formula.
"""

import sys
from typing import Any, TypeAlias

import numpy as np

Value: TypeAlias = Any
"""A float, a numpy array, or a UFL expression: UFL itself is not typed."""


def is_symbolic(*values: Value) -> bool:
    """Tell whether any of the values is a UFL expression."""
    ufl = sys.modules.get("ufl")  # where nobody has imported it there is none; it takes a tenth of a second
    return ufl is not None and any(isinstance(value, ufl.core.expr.Expr) for value in values)


def number_of(value: Value) -> float:
    """The number of a UFL constant, or of a number."""
    return float(value.value if hasattr(value, "value") else value)


def scaled(x: Value, factor: Value) -> Value:
    """factor x; x itself where the factor is the number 1, which leaves no trace in a form."""
    return x if isinstance(factor, float) and factor == 1.0 else factor * x


def exp(x: Value) -> Value:
    """exp(x)."""
    return sys.modules["ufl"].exp(x) if is_symbolic(x) else np.exp(x)


def ln(x: Value) -> Value:
    """Natural logarithm of x > 0."""
    return sys.modules["ufl"].ln(x) if is_symbolic(x) else np.log(x)


def sqrt(x: Value) -> Value:
    """Square root of x >= 0."""
    return sys.modules["ufl"].sqrt(x) if is_symbolic(x) else np.sqrt(x)


def where_less(a: Value, b: Value, if_less: Value, otherwise: Value) -> Value:
    """`if_less` where a < b, else `otherwise`; both branches must be finite everywhere."""
    if is_symbolic(a, b, if_less, otherwise):
        ufl = sys.modules["ufl"]
        return ufl.conditional(ufl.lt(a, b), if_less, otherwise)
    return np.where(np.less(a, b), if_less, otherwise)[()]


def maximum(a: Value, b: Value) -> Value:
    """The larger of a and b."""
    return where_less(a, b, b, a)


def minimum(a: Value, b: Value) -> Value:
    """The smaller of a and b."""
    return where_less(a, b, a, b)


def positive_part(x: Value, width: Value) -> Value:
    """Smooth positive part (x + sqrt(x^2 + width^2)) / 2 for width > 0: equal to x where x >> width.

    A thousandth of the width on top keeps it positive where x << -width, and rounding would leave 0.
    """
    return 0.5 * (x + sqrt(x * x + width * width)) + 1e-3 * width


def smooth_step(x: Value, start: Value, end: Value) -> Value:
    """Cubic 3 s^2 - 2 s^3 of s = (x - start)/(end - start): 0 below `start`, 1 above `end`, C1 between."""
    s = minimum(maximum((x - start) / (end - start), 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s)


def one_minus_exp_over(x: Value) -> Value:
    """(1 - exp(-x))/x for x >= 0, by its series below 1e-4, where the quotient loses its digits."""
    safe = maximum(x, 1e-4)
    return where_less(x, 1e-4, 1.0 - 0.5 * x, (1.0 - exp(-safe)) / safe)
