"""The page of a report: sections of sentences, tables and pictures, and its template (`report.html.jinja`)."""

import base64
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar, TypeAlias

import markupsafe
from jinja2 import Environment, PackageLoader, StrictUndefined

from .. import __version__


@dataclass(frozen=True)
class Sentence:
    """A paragraph; its `look` may be 'large' or 'warning'."""

    kind: ClassVar = "sentence"
    text: str
    look: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of cells under a head; numbers (float) stand right."""

    kind: ClassVar = "table"
    head: Sequence[str]
    rows: Sequence[Sequence[object]]


@dataclass(frozen=True)
class Picture:
    """A PNG file, which becomes part of the page."""

    kind: ClassVar = "picture"
    path: Path

    @property
    def data(self) -> str:
        """Its content for a data URL."""
        return base64.b64encode(self.path.read_bytes()).decode()


@dataclass(frozen=True)
class Markup:
    """HTML that the program wrote itself."""

    kind: ClassVar = "markup"
    text: str


Block: TypeAlias = Sentence | Table | Picture | Markup


@dataclass(frozen=True)
class Section:
    """Blocks under a title, which may be empty; without any the section is left out."""

    title: str
    blocks: Sequence[Block] = field(default=())


def _breakable(text: str) -> markupsafe.Markup:
    """A key's name, which may be broken after its parts."""
    return markupsafe.Markup(re.sub(r"([._])", r"\1<wbr>", str(markupsafe.escape(text))))


def rendered(title: str, sections: Sequence[Section]) -> str:
    """The page as HTML; every text in it is escaped."""
    loader = PackageLoader("porousmold.output", "")
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters["breakable"] = _breakable
    template = environment.get_template("report.html.jinja")
    return template.render(title=title, sections=[one for one in sections if one.blocks], version=__version__)
