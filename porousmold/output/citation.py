"""BibTeX of what a run used: the program, the thesis whose model it solves, and the sources of closures and materials."""

import json
import re
from collections.abc import Iterable
from pathlib import Path

from ..errors import InputError
from .result_keys import Summary

THESIS = """@phdthesis{sun2021,
  author = {Sun, Yixun},
  title = {Flow and Heat Transfer Analysis in Granular Beds for Injection Molding},
  school = {Polytechnique Montr{\\'e}al},
  year = {2021},
  url = {https://publications.polymtl.ca/10250/}
}"""
ARTICLE = re.compile(
    r"(?P<author>.+?), (?P<journal>[^,]+?) (?P<volume>\d+) \((?P<year>\d{4})\)(?:[, ]+(?P<pages>[\d-]+))?"
)
OTHER = re.compile(r"(?P<author>[^\d(:]+?),? (?P<year>(?:18|19|20)\d{2})\b")


def citations(folder: Path) -> str:
    """What the run in a folder used, as BibTeX with a comment before each entry that tells for what.

    Raises `InputError` where the folder holds no result.
    """
    try:
        summary = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        version, sources = summary["versions"]["porousmold"], _sources(summary)
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise InputError("RUN", str(folder), "is not the folder of a run (no result.json that can be read)") from error
    program = "@software{porousmold,\n  author = {{The authors of porousmold}},\n  title = {porousmold},\n"
    program += f"  version = {{{version}}}\n}}"
    entries = [f"% the program\n{program}", f"% the model\n{THESIS}"]
    keys: set[str] = set()
    for text, uses in sources.items():
        entries.append(f"% {', '.join(uses)}\n{_entry(text, keys)}")
    return "\n\n".join(entries)


def _sources(summary: Summary) -> dict[str, list[str]]:
    """{source: what it is used for}, but for the thesis alone and the scene itself."""
    used = [(what, text) for what, text in summary["sources"].items()]
    for owner, material in summary["materials"].items():
        used += [(f"{material['material']} ({owner})", each["source"]) for each in material["properties"].values()]
    found: dict[str, list[str]] = {}
    for what, text in used:
        for part in _parts(text):
            if what not in found.setdefault(part, []):
                found[part].append(what)
    return found


def _parts(text: str) -> Iterable[str]:
    """The references of a source: those between semicolons, without equations of the thesis."""
    for part in text.split(";"):
        if (ARTICLE.search(part) or OTHER.search(part)) and not part.strip().startswith("thesis"):
            yield part.strip()


def _entry(text: str, keys: set[str]) -> str:
    match = ARTICLE.search(text) or OTHER.search(text)
    assert match is not None
    fields = {name: value.strip(" ,") for name, value in match.groupdict().items() if value}
    author = re.sub(r"^.*: ", "", fields["author"])
    others, author = "et al." in author, author.replace("et al.", "")
    names = [name.strip() for name in re.split(r",| and | & ", author) if name.strip()]
    fields["author"] = " and ".join(names) + (" and others" if others else "")
    key = stem = re.sub(r"\W", "", names[0].split()[-1].lower() if names else "anonymous") + fields["year"]
    for letter in "bcdefghijklmnopqrstuvwxyz":
        if key not in keys:
            break
        key = stem + letter
    keys.add(key)
    kind = "article" if "journal" in fields else "misc"
    lines = [f"  {name} = {{{value}}}" for name, value in fields.items()]
    note = text.replace("{", "").replace("}", "")
    return f"@{kind}{{{key},\n" + ",\n".join([*lines, f"  note = {{{note}}}"]) + "\n}"
