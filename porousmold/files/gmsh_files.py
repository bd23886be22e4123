"""Files that gmsh reads, safe to open: a script (.geo) may start processes and write files, so that it is checked before.

gmsh parses whatever is no mesh as a script, whatever its name, and with a file also a companion of its name and `.opt`. A script
that anybody sent may be opened here only where it holds none of `FORBIDDEN`; a mesh has to begin as one; and both are opened in a
folder of their own, where they have no companion.
"""

import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

SCRIPTS = (".geo", ".geo_unrolled")
MESH_HEADS = (b"$MeshFormat", b"$Comments", b"$NOD")
"""First bytes of what gmsh takes for a mesh."""
CAD_FILES = (".step", ".stp", ".brep", ".iges", ".igs")
"""Files that a script may merge: gmsh tells them by their names, and none of them holds commands."""
FORBIDDEN = {
    **dict.fromkeys(
        ("System", "SystemCall", "NonBlockingSystemCall", "OnelabRun", "OnelabAction", "ExternalProcess", "CommandLine",
         "SendToServer", "Solver"),
        "starts a process",
    ),
    **dict.fromkeys(
        ("Include", "Merge", "MergeWithBoundingBox", "ShapeFromFile", "FileName", "Plugin", "PostProcessing", "View",
         "PostView", "SetString", "SetNumber", "General", "GetEnv"),
        "opens another file or changes gmsh's own settings",
    ),
    **dict.fromkeys(("Save", "Print", "CreateDir", "Homology", "Cohomology"), "writes files"),
    **dict.fromkeys(("StringToName", "NameFromString", "S2N", "N2S"), "makes names of texts"),
    **dict.fromkeys(("Exit", "Abort"), "ends the program"),
}  # fmt: skip
"""Words of gmsh's language, and what they do."""
_ALLOWED_SETTINGS = re.compile(r"\bGeneral\s*\.\s*(Terminal|Verbosity|NumThreads|ExpertMode)\b")
_MERGE = re.compile(r'\bMerge\s+"([^"\n]+)"\s*;')
_REDIRECTED = re.compile(r"\b(?:Printf|Error|Warning)\b[^;]*?\)\s*>")
_MACRO_OF_TEXT = re.compile(r"\b(?:Macro|Function)\s*\(")
_COMMENT = r"//[^\n\r]*|/\*.*?\*/"
_READINGS = tuple(
    re.compile(f"{strings}{_COMMENT}", re.DOTALL) for strings in ("", r'"[^"]*"|', r"""\"[^"]*"|'[^']*'|""")
)
"""Comments, with strings of no, one and both kinds of quotes: a word counts where any reading takes it for one."""


def is_mesh(path: Path) -> bool:
    """Whether a file begins as a mesh of gmsh's."""
    with path.open("rb") as file:
        return file.read(16).startswith(MESH_HEADS)


def refusal(path: Path) -> str | None:
    """Why a file is not to be opened by gmsh unless it is trusted; None where it may be. Raises `OSError`."""
    if is_mesh(path):
        return None
    if path.suffix.lower() == ".msh":
        return "is no mesh: it does not begin with $MeshFormat"
    if path.suffix.lower() not in SCRIPTS:
        return "is neither a mesh of gmsh's (.msh) nor a geometry (.geo); if you trust the file: --allow-extensions"
    script = path.read_bytes().decode("latin-1")
    for reading in _READINGS:
        for number, word, does in _forbidden(_without_comments(script, reading), path.parent):
            return f"line {number}: {word!r} {does}; if you trust the file: --allow-extensions"
    return None


def merged_files(path: Path) -> list[Path]:
    """The CAD files that a script merges."""
    if is_mesh(path) or path.suffix.lower() not in SCRIPTS:
        return []
    names = _MERGE.findall(path.read_bytes().decode("latin-1"))
    return sorted({path.parent / name for name in names if _is_cad_file(path.parent / name)})


@contextmanager
def without_companions(path: Path) -> Iterator[Path]:
    """A mesh, or a script with the CAD files that it merges, in a folder with nothing else. Raises `ValueError` where it is to be
    refused, and `OSError`."""
    if (reason := refusal(path)) is not None:
        raise ValueError(reason)
    with tempfile.TemporaryDirectory(prefix="porousmold-") as name:
        here = Path(name) / path.name
        if is_mesh(path):
            here.symlink_to(path.resolve())
        else:
            copies = {}
            for number, file in enumerate(merged_files(path)):
                copies[file] = Path(name) / f"drawing_{number}{file.suffix}"
                copies[file].symlink_to(file.resolve())

            def of_copy(match: re.Match[str]) -> str:
                file = path.parent / match[1]
                return f'Merge "{copies[file].name}";' if file in copies else match[0]

            here.write_text(_MERGE.sub(of_copy, path.read_bytes().decode("latin-1")), encoding="latin-1")
        yield here


def _is_cad_file(path: Path) -> bool:
    return path.suffix.lower() in CAD_FILES and path.is_file()


def _without_comments(script: str, comments: re.Pattern[str]) -> str:
    """The script with blanks for its comments, line by line as before."""

    def blank(match: re.Match[str]) -> str:
        return match[0] if match[0][0] in "\"'" else " " + "\n" * match[0].count("\n")

    return comments.sub(blank, script)


def _forbidden(script: str, folder: Path) -> Iterator[tuple[int, str, str]]:
    """Line, word and deed of every forbidden word."""
    for match in _MERGE.finditer(script):
        if _is_cad_file(folder / match[1]):
            script = script[: match.start()] + " " * len(match[0]) + script[match.end() :]
    script = _ALLOWED_SETTINGS.sub(lambda match: " " * len(match[0]), script)
    found = [
        (match.start(), match[0], FORBIDDEN[match[0]])
        for match in re.finditer(r"[A-Za-z_]\w*", script)
        if match[0] in FORBIDDEN
    ]
    found += [(m.start(), m[0].split("(")[0].strip(), "writes a file") for m in _REDIRECTED.finditer(script)]
    found += [(m.start(), m[0].strip(), "runs a text as commands") for m in _MACRO_OF_TEXT.finditer(script)]
    for start, word, does in sorted(found):
        yield script.count("\n", 0, start) + 1, word, does
