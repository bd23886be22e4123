"""Scenes drawn at random: values of a Latin hypercube."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from scipy.stats import qmc


def draws(
    ranges: Mapping[str, tuple[float, float, bool]], choices: Mapping[str, Sequence[Any]], count: int, seed: int
) -> Iterator[dict[str, Any]]:
    """`count` draws: of every range (from, to, whether evenly in the logarithm) a number, of all choices one."""
    names = [*ranges, *choices]
    for point in qmc.LatinHypercube(len(names), seed=seed).random(count):
        drawn: dict[str, Any] = dict(zip(names, point, strict=True))
        for name, (low, high, logarithmic) in ranges.items():
            part = drawn[name]
            drawn[name] = low * (high / low) ** part if logarithmic else low + part * (high - low)
        for name, options in choices.items():
            drawn[name] = options[int(drawn[name] * len(options))]
        yield drawn
