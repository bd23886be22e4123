"""The pictures of a run in a process of their own, which makes itself ready while the run is computed."""

import contextlib
import gc
import json
import os
import subprocess
import sys
from pathlib import Path

from ..errors import InputError, OutputError


class PictureProcess:
    """A process that imports matplotlib and waits for the folder to draw. It ends with this one, whatever happens to that."""

    def __init__(self) -> None:
        # with a session of its own, Ctrl-C reaches the run alone
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def draw(self, folder: Path) -> list[Path]:
        """The pictures of a run's folder, drawn. Raises errors like `pictures.draw`, and `OutputError` where the process died."""
        assert self._process.stdin is not None and self._process.stdout is not None
        answer = ""
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.write(f"{folder}\n")
            self._process.stdin.flush()
            answer = self._process.stdout.readline()  # its end, which takes a tenth of a second, is not waited for
        if not answer:
            raise OutputError(folder, "no picture was drawn", "'porousmold show' tries again")
        given = json.loads(answer)
        if "no room" in given:
            raise OutputError(*given["no room"])
        if "error" in given:
            raise InputError(*given["error"])
        return [Path(path) for path in given["drawn"]]

    def close(self) -> None:
        """End the process, if it has not ended."""
        self._process.kill()
        self._process.communicate()


def _wait_and_draw() -> None:
    from .figures import plt
    from .pictures import draw

    figure = plt.figure(figsize=(1.0, 1.0))  # the first one looks for fonts
    figure.text(0.5, 0.5, "$\\phi$ in m²")
    figure.canvas.draw()
    plt.close(figure)
    gc.disable()  # nothing of a process this short is worth collecting: a fifth of the time
    folder = sys.stdin.readline().rstrip("\n")
    if not folder:
        return
    try:
        answer: dict[str, list[str]] = {
            "drawn": [str(path) for path in draw(Path(folder), len(os.sched_getaffinity(0)))]
        }
    except OutputError as error:
        answer = {"no room": list(error.args)}
    except InputError as error:
        answer = {"error": [error.key, str(error.value), error.allowed]}
    print(json.dumps(answer), flush=True)
    os._exit(0)


if __name__ == "__main__":
    _wait_and_draw()
