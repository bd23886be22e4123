"""Step sizes: ramp, cap, breakpoints, repetition."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from porousmold.errors import SolveError
from porousmold.solvers.time_control import TimeControl


def integrated(control, error=lambda time, step: 0.0, limit=10000):
    """(times, steps) of an integration in which every step has the given error."""
    time, times, steps = 0.0, [0.0], []
    while time < control.end_time * (1 - 1e-12) and len(steps) < limit:
        step = control.propose(time)
        if control.accept(time + step, step, error(time, step)):
            time += step
            times.append(time)
            steps.append(step)
    return times, steps


@given(
    first=st.floats(0.01, 10.0),
    growth=st.floats(1.0, 3.0),
    cap=st.floats(5.0, 50.0),
    breakpoints=st.lists(st.floats(1.0, 999.0), max_size=4),
)
def test_hits_every_kink_and_the_end_within_the_cap(first, growth, cap, breakpoints):
    breakpoints = tuple(sorted(breakpoints))
    times, steps = integrated(TimeControl(first, max(growth, 1.05), cap, 1000.0, breakpoints))
    assert times[-1] == pytest.approx(1000.0)
    assert max(steps) <= max(cap, first) * (1 + 1e-9)
    assert all(min(abs(time - instant) for time in times) < 1e-6 for instant in breakpoints)


def test_quiet_steps_grow_beyond_the_cap_and_those_after_them_do_not():
    control = TimeControl(1.0, 2.0, 20.0, 1e4)
    control.step = 20.0
    assert control.accept(20.0, 20.0, 0.0, is_quiet=True)
    assert control.propose(20.0) == 40.0
    assert control.accept(60.0, 40.0, 0.0)
    assert control.propose(60.0) == 20.0


def test_ramps_geometrically_and_small_again_after_a_kink():
    times, steps = integrated(TimeControl(1.0, 2.0, 20.0, 200.0, (100.0,)))
    assert steps[:5] == [1.0, 2.0, 4.0, 8.0, 16.0]
    after = next(i for i, time in enumerate(times) if time == pytest.approx(100.0))
    assert steps[after] == 1.0


def test_large_errors_repeat_the_step_smaller():
    control = TimeControl(1.0, 2.0, 20.0, 100.0)
    times, steps = integrated(control, error=lambda time, step: (step / (5.0 if time < 40.0 else 1.0)) ** 2)
    assert control.rejected >= 1 and max(steps) <= 5.0 * (1 + 1e-9)
    assert max(step for time, step in zip(times, steps, strict=False) if time > 45.0) <= 1.0 + 1e-9


def test_steps_settle_where_the_error_is_just_allowed():
    """An error of the order 3 that grows with time: steps follow it, hardly any is repeated."""
    control = TimeControl(0.1, 2.0, 1e3, 1e3)
    times, steps = integrated(control, error=lambda time, step: (step / (10.0 + 0.02 * time)) ** 3)
    late = [step / (10.0 + 0.02 * time) for time, step in zip(times, steps, strict=False) if 100.0 < time < 900.0]
    assert 0.7 < min(late) <= max(late) <= 1.0 and control.rejected <= 2


def test_no_step_is_longer_than_asked():
    control = TimeControl(1.0, 2.0, 100.0, 1e4)
    control.step = 50.0
    assert control.propose(10.0, 20.0) == 20.0
    assert control.propose(10.0, 0.1) == 1.0, "below the first step nothing is gained"


def test_gives_up_with_the_failure_itself():
    control = TimeControl(1.0, 2.0, 10.0, 100.0)
    failure = SolveError("energy", 0.0, "detail", "advice")
    with pytest.raises(SolveError) as caught:
        for _ in range(100):
            control.reject_failed(control.step, failure)
    assert caught.value is failure
    assert control.rejected < 20


def test_going_on_after_solves_gave_up_starts_small_again():
    control = TimeControl(1.0, 1.5, 100.0, 1e4)
    control.go_on_with(40.0)
    assert control.propose(10.0) == 40.0
    control.go_on_with(1e-9)
    assert control.propose(10.0) == 1.0


def test_what_changes_slowly_does_not_jump():
    """The start jumps, and a series that changes within a first step (50 to 50.5 s), not one of rows 20 s apart."""
    control = TimeControl(1.0, 2.0, 20.0, 200.0, (20.0, 40.0, 50.0, 50.5))
    near = [time for time in (0.0, 2.9, 3.1, 20.0, 40.0, 50.0, 50.5, 53.0, 60.0) if control.after_jump(time)]
    assert near == [0.0, 2.9, 50.5, 53.0]


def test_what_takes_a_hundred_of_the_largest_steps_takes_longer_ones():
    """Geometrically, by a hundredth of the time since the last change; none where the largest step is the user's."""
    for late in (0.01, 0.0):
        control = TimeControl(1.0, 2.0, 4.0, 1e5, breakpoints=(2e4,), late_part=late)
        time, steps = 0.0, []
        while time < 1e5:
            step = control.propose(time)
            time += step
            steps.append((time, step))
            assert control.accept(time, step, 0.1)
        assert all(step <= 4.0 * (1 + 1e-9) for end, step in steps if end < 400.0 or 2e4 < end < 2.04e4)
        longest = max(step for _, step in steps)
        assert longest == pytest.approx(max(late * 8e4, 4.0), rel=0.03)


def test_steps_of_small_error_exceed_the_largest_one():
    """A slow ramp: until their error, of third order in their length, is a hundredth of what is allowed; not where it is more,
    and not where the largest step is the user's."""
    for at_largest, late, longest in ((1e-5, 0.01, 40.0), (0.02, 0.01, 4.0), (1e-5, 0.0, 4.0)):
        control = TimeControl(1.0, 1.5, 4.0, 390.0, late_part=late)
        time, steps = 0.0, []
        while time < 390.0:
            step = control.propose(time)
            time += step
            steps.append(step)
            assert control.accept(time, step, at_largest * (step / 4.0) ** 3)
        assert max(steps) == pytest.approx(longest, rel=0.01)
