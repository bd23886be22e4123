"""Wall seconds by purpose."""

import contextlib
import time as clock
from collections.abc import Iterator

PURPOSES = ("compile", "mesh", "flow", "energy", "output")


class Stopwatch:
    """`seconds` by purpose; `with stopwatch(purpose):` adds to them."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(PURPOSES, 0.0)

    @contextlib.contextmanager
    def __call__(self, purpose: str) -> Iterator[None]:
        start = clock.perf_counter()
        try:
            yield
        finally:
            self.seconds[purpose] += clock.perf_counter() - start
