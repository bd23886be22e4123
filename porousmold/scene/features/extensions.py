"""Laws from outside the package."""

from dataclasses import dataclass
from pathlib import Path

from .feature import Feature, key


@dataclass(frozen=True, kw_only=True)
class Extensions(Feature):
    """A file that registers them."""

    python: Path | None = key(
        "extensions.python",
        "file",
        "Python file that registers user-defined laws; run only with --allow-extensions",
    )
