"""Handling of SIGINT (Ctrl-C) and SIGTERM.

The first signal sets a flag; the command ends in an orderly way at its next check of the flag and writes its results. A second
signal kills the process at once (default action of the kernel). A library call may take minutes (a factorisation, the assembly
of a million cells), during which Python handles no signals. Therefore a watchdog process ends the command `PATIENCE` seconds
after the first signal, unless the command has acknowledged it by then. That is where the flag is checked, or where
`KeyboardInterrupt` is caught at last, not where it is raised: one that is raised while Python forks, or deletes an object, is
printed and forgotten.
"""

import contextlib
import ctypes
import os
import select
import signal
import sys
import time

PATIENCE = 1.5
"""Seconds that a command has to see a signal."""


class StopSignals:
    """True once a signal has come. From its making on SIGINT and SIGTERM are only noted, once it has been asked for the first
    time; until then they raise `KeyboardInterrupt`, so that imports, meshing and compilation end, too."""

    def __init__(self) -> None:
        self._received: list[int] = []
        self._asked = False
        reading, self._writing = os.pipe()
        os.set_blocking(self._writing, False)
        parent = os.getpid()
        if os.fork() == 0:
            os.close(self._writing)
            _watch(reading, parent)
        os.close(reading)
        signal.set_wakeup_fd(self._writing, warn_on_full_buffer=False)
        self.listen()

    def listen(self) -> None:
        """Take the signals; to be called again after an import of PETSc, which takes SIGTERM for itself."""
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._note)
            _only_once(number)

    def _note(self, number: int, frame: object) -> None:
        self._received.append(number)
        if not self._asked:
            raise KeyboardInterrupt

    def __bool__(self) -> bool:
        self._asked = True
        if self._received:
            acknowledge()
        return bool(self._received)


def acknowledge() -> None:
    """Tell the watchdog that the signal was seen: the command ends in an orderly way, in the time that this takes."""
    watchdog = signal.set_wakeup_fd(-1)
    if watchdog != -1:
        os.write(watchdog, b"\0")


def _only_once(number: int) -> None:
    """Have the kernel forget the signal's handler once it was called: a second signal then has its default effect."""
    library = ctypes.CDLL(None)
    library.sysv_signal.restype = ctypes.c_void_p
    library.sysv_signal.argtypes = [ctypes.c_int, ctypes.c_void_p]
    library.sysv_signal(number, library.sysv_signal(number, None))


def _watch(reading: int, parent: int) -> None:
    """Wait for a signal's number in the pipe, or its end, and end the parent if it does not end by itself."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    if os.read(reading, 1) not in (b"", b"\0"):
        seen, _, _ = select.select([reading], [], [], PATIENCE)
        if not seen or os.read(reading, 1) not in (b"", b"\0"):
            print("porousmold: stopped within a long call; --resume goes on from what was saved", file=sys.stderr)
            with contextlib.suppress(ProcessLookupError):  # it has ended by itself meanwhile
                for _ in range(2):  # the first one may still be noted
                    os.kill(parent, signal.SIGINT)
                    time.sleep(0.05)
                os.kill(parent, signal.SIGKILL)
    os._exit(0)
