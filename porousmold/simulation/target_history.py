"""What became of a target over a whole run: when it was lost and kept, how long it held, how nearly it was met or lost."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from .targets import Rows, Target


@dataclass(frozen=True)
class Turn:
    """What was `left` (K) to a target's margin where its course turned, positive where it holds, at a `time` (s); whether the
    course came from the side where it holds."""

    left: float
    time: float
    held_before: bool


def lost_and_kept(target: Target, history: Rows, met: float) -> tuple[float | None, float | None]:
    """When it was lost first (s) after it was `met`, and from when it holds up to the end; None where that is not so."""
    rows = [row for row, time in enumerate(history["time"]) if time >= met]
    lost, kept = None, met - target.hold
    for before, row in pairwise(rows):
        was, now = target.holds(history, before), target.holds(history, row)
        if was == now:
            continue
        crossing = target.crossing(history, row, falls=now)
        if was and lost is None:
            lost = crossing
        kept = crossing
    return lost, kept if rows and target.holds(history, rows[-1]) else None


def longest_hold(target: Target, history: Rows) -> tuple[float, float] | None:
    """When it began to hold and ceased to (s), the longest time that it did; None where it never held."""
    periods, began = [], None
    for row in _counting_rows(target, history):
        if target.holds(history, row) == (began is not None):
            continue
        if began is None:
            began = target.crossing(history, row, falls=True) if row else history["time"][row]
        else:
            periods.append((began, target.crossing(history, row, falls=False)))
            began = None
    if began is not None:
        periods.append((began, history["time"][-1]))
    return max(periods, key=lambda period: period[1] - period[0]) if periods else None


def narrowest(target: Target, history: Rows) -> Turn | None:
    """Where it turned back nearest to its margin, or was coming nearer at the end; None where it never did, and of a cure."""
    if target.asks == "cured":
        return None
    rows = _counting_rows(target, history)
    left = [target.margin - target.course(history, row) for row in rows]
    return narrowest_turn([history["time"][row] for row in rows], left)


def narrowest_turn(times: Sequence[float], left: Sequence[float]) -> Turn | None:
    """Where a course turned back nearest to a margin to which it has `left` (K) so much at some times (s), positive within,
    or was coming nearer from within at the end; None where it never did."""
    turns = []
    for row in range(1, len(left)):
        before, now, after = left[row - 1], left[row], left[min(row + 1, len(left) - 1)]
        if now < before and now <= after:
            turns.append(Turn(now, times[row], held_before=True))
        elif before < now and after < now:
            turns.append(Turn(now, times[row], held_before=False))
    return min(turns, key=lambda turn: abs(turn.left)) if turns else None


def _counting_rows(target: Target, history: Rows) -> Sequence[int]:
    """From when on it counts: a limit that is gone through twice has been passed, and a spread is under way."""
    rows = range(len(history["time"]))
    first = next((row for row in rows if target.is_beyond(history, row)), len(rows))
    if target.asks == "spread":
        first = next((row for row in rows if target.way_gone(history, row) > 1.0), len(rows))
    return rows[first:]
