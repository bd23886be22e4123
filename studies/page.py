"""What the studies share: a Markdown page that is shown as it grows, and the yardstick of this machine."""

import os
import statistics
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu


class Page:
    """Lines of a Markdown page, printed as they come."""

    def __init__(self, *lines: str) -> None:
        self.lines: list[str] = []
        self.add(*lines)

    def add(self, *lines: str) -> None:
        """More lines."""
        self.lines += lines
        print("\n".join(lines), flush=True)

    def head(self, *names: str) -> None:
        """Begin a table."""
        self.add("", row(names), "|" + "---|" * len(names))

    def row(self, *cells: object) -> None:
        """A line of the table."""
        self.add(row(cells))

    def table(self, head: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
        """A whole table."""
        self.head(*head)
        for cells in rows:
            self.row(*cells)
        self.add("")

    def write(self, path: Path) -> None:
        """Write the page."""
        path.write_text("\n".join(self.lines).rstrip("\n") + "\n", encoding="utf-8")


def strategies(of_runs: Iterable[Mapping[str, int]]) -> list[str]:
    """Lines of a table of how the flows of some runs were found (`flow_strategies`): in how many runs, and how often."""
    times: Counter[str] = Counter()
    runs: Counter[str] = Counter()
    for counts in of_runs:
        times.update(counts)
        runs.update(counts.keys())
    found = [row((name, runs[name], count)) for name, count in times.most_common()]
    return [row(("how a flow was found", "runs", "times")), "|---|---|---|", *found]


def row(cells: Iterable[object]) -> str:
    """A line of a table."""
    return "| " + " | ".join(map(str, cells)) + " |"


def yardstick(*, of_cpu: bool = False) -> float:
    """Y: median seconds of one sparse LU factorisation of the 5-point Laplacian on 300 x 300 nodes: this machine, this minute.

    By the clock, or of CPU time, which others disturb less. In a process of its own: one that has freed much memory takes
    a quarter less, as the system need not give it any.
    """
    # MPI puts into this process's environment what makes another one take itself for launched by mpirun
    child = subprocess.run([sys.executable, "-m", __name__], check=True, capture_output=True, env=dict(os.environ))
    return float(child.stdout.split()[of_cpu])


def factorisations(repetitions: int = 3, clock: Callable[[], float] = time.perf_counter) -> list[float]:
    """Seconds of each of some such factorisations, by a clock."""
    ones = np.ones(300)
    line = sparse.diags([-ones[:-1], 2 * ones, -ones[:-1]], [-1, 0, 1])
    laplacian = (sparse.kron(sparse.eye(300), line) + sparse.kron(line, sparse.eye(300))).tocsc()
    seconds = []
    for _ in range(repetitions):
        start = clock()
        splu(laplacian)
        seconds.append(clock() - start)
    return seconds


if __name__ == "__main__":
    print(*(statistics.median(factorisations(clock=clock)) for clock in (time.perf_counter, time.process_time)))
