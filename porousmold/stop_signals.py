"""The signals that end a run in good order."""

import signal


def received():
    """From now on SIGINT and SIGTERM are only noted, in the list that this gives: every rank must stop at the same step."""
    signals: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, frame: signals.append(number))
    return signals
