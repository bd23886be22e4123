"""The errors that end a run with one line: what the user wrote wrong, and what could not be solved."""


def _one_line(text: str) -> str:
    """The text with line breaks and other control characters (of a file's name, say) as escapes."""
    return "".join(letter if letter.isprintable() else repr(letter)[1:-1] for letter in text)


class InputError(ValueError):
    """Bad input: names the key, its value, what is allowed and (where known) the file it stands in."""

    def __init__(self, key: str, value: object, allowed: str, where: str | None = None) -> None:
        self.key, self.value, self.allowed, self.where = key, value, allowed, where
        super().__init__(key, value, allowed, where)

    def __str__(self) -> str:
        place = f" (in {self.where})" if self.where else ""
        if isinstance(self.value, float):
            shown = f" = {float(f'{self.value:.9g}')!r}"
        elif isinstance(self.value, int | str | None):
            shown = f" = {self.value!r}" if self.value is not None else ""
        else:
            shown = f" = {str(self.value)!r}"
        return _one_line(f"{self.key}{shown}: {self.allowed}{place}")


class OutputError(InputError):
    """A file that can no longer be written while the work goes on (a full disk): what was written before is kept."""

    def __init__(self, path: object, problem: Exception | str, go_on: str) -> None:
        self.reason = (problem.strerror if isinstance(problem, OSError) else None) or str(problem)
        super().__init__("--out", str(path), f"cannot be written any more: {self.reason}; {go_on}")
        self.args = (str(path), self.reason, go_on)  # from which another process makes it again


class SolveError(RuntimeError):
    """A solve that did not converge: the time (s), the block of equations, the residuals, and advice."""

    def __init__(self, block: str, time: float, detail: str, advice: str) -> None:
        self.block, self.time, self.detail, self.advice = block, time, detail, advice
        super().__init__(block, time, detail, advice)

    def __str__(self) -> str:
        return _one_line(f"{self.block} failed at t = {self.time:.6g} s: {self.detail}; try {self.advice}")


def first_line(error: Exception) -> str:
    """Kind of an error of foreign code, and the first line of its message."""
    return f"{type(error).__name__}: {error}".splitlines()[0].rstrip(": ")
