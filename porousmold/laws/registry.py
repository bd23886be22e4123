"""Laws by name: those of the package, of installed packages and of a user's own Python file.

A `Registry` holds the laws of one kind. A scene's choices are looked up in it when the scene is checked, so that a law
registered before that is as good as one of the package. Other packages name a module that registers theirs as an entry point
of the group `porousmold.laws`; a scene names a file as `extensions.python`.
"""

import functools
import hashlib
import importlib.util
import inspect
import sys
from collections.abc import Callable, Iterator, Mapping
from importlib.machinery import SourceFileLoader
from importlib.metadata import entry_points
from pathlib import Path
from typing import Generic, TypeVar

from ..errors import InputError, first_line

Law = TypeVar("Law")
ENTRY_POINTS = "porousmold.laws"
_PACKAGE = __name__.split(".")[0]


class Registry(Mapping[str, Law], Generic[Law]):
    """Laws of one `kind` ("nusselt", "solid", ...) by name, in the order of their registration."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._laws: dict[str, Law] = {}
        self._makers: dict[str, Callable[[], Law]] = {}
        self._own: set[str] = set()

    def register(self, name: str, law: Law) -> Law:
        """Add a law under a name. Raises `InputError` where the package itself has a law of that name."""
        if not isinstance(name, str) or not name or name != name.strip():
            raise InputError(f"{self.kind} law", name, "must have a name: a text without blanks at its ends")
        if name in self._own:
            raise InputError(f"{self.kind} law", name, "is a name that a law of the package has")
        if _registering_module().split(".")[0] == _PACKAGE:
            self._own.add(name)
        self._laws[name] = law
        return law

    def register_later(self, name: str, make: Callable[[], Law]) -> None:
        """Add a law of the package that is made when it is first asked for."""
        self._own.add(name)
        self._makers[name] = make

    def is_own(self, name: str) -> bool:
        """Whether the law belongs to the package."""
        return name in self._own

    def __getitem__(self, name: str) -> Law:
        if name not in self._laws and name in self._makers:
            self._laws[name] = self._makers[name]()
        return self._laws[name]

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys([*self._makers, *self._laws]))

    def __len__(self) -> int:
        return len(list(iter(self)))


def _registering_module() -> str:
    """Name of the module whose code registers: the nearest one outside this file and the decorators."""
    frame = inspect.currentframe()
    while frame is not None:
        name = str(frame.f_globals.get("__name__", ""))
        if name not in (__name__, f"{_PACKAGE}.laws.extension", "dataclasses", "functools"):
            return name
        frame = frame.f_back
    return ""


@functools.cache
def load_entry_points() -> None:
    """Import what installed packages name in the group `porousmold.laws`. Raises `InputError` where that fails."""
    for point in entry_points(group=ENTRY_POINTS):
        try:
            point.load()
        except Exception as error:
            raise InputError(
                f"entry point {point.name}", point.value, f"cannot be loaded: {first_line(error)}"
            ) from error


def load_file(path: Path) -> None:
    """Run a Python file that registers laws, once for each content. Raises `InputError` where it fails."""
    _load(path, path.read_bytes())


@functools.cache
def _load(path: Path, source: bytes) -> None:
    name = f"porousmold_extension_{hashlib.sha256(source).hexdigest()[:12]}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or not isinstance(spec.loader, SourceFileLoader):
        raise InputError("extensions.python", str(path), "must be a Python file (.py)")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # inspect and dataclasses look there
    try:
        # not exec_module: its bytecode cache tells files by size and second, and lies beside the user's file
        exec(spec.loader.source_to_code(source, str(path)), module.__dict__)
    except InputError:
        raise
    except Exception as error:
        raise InputError("extensions.python", str(path), f"cannot be run: {first_line(error)}") from error


def source_text(law: object) -> str:
    """Text that changes with what a law computes: the source of its functions and class, and its numbers."""
    if callable(law) and hasattr(law, "__code__"):
        try:
            return inspect.getsource(law)
        except (OSError, TypeError):  # typed at a prompt
            return repr((law.__code__.co_code, law.__code__.co_consts, law.__code__.co_names))
    parts = [type(law).__qualname__]
    if not type(law).__module__.startswith(f"{_PACKAGE}."):
        try:
            parts.append(inspect.getsource(type(law)))
        except (OSError, TypeError):
            parts += [source_text(value) for value in vars(type(law)).values() if hasattr(value, "__code__")]
    for name, value in sorted(getattr(law, "__dict__", {}).items()):
        nested = callable(value) or hasattr(value, "__dataclass_fields__")
        parts.append(f"{name} = {source_text(value) if nested else value!r}")
    return "\n".join(parts)
