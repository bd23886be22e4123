"""Who may import whom: docs/architecture.md, held."""

import ast
import re
from pathlib import Path

import porousmold

PACKAGE = Path(porousmold.__file__).parent
PAGE = (PACKAGE.parent / "docs" / "architecture.md").read_text(encoding="utf-8")
MODULES_AT_THE_TOP = 6
LONGEST_CLASS, MOST_PARAMETERS = 200, 8
"""In lines; without self."""


def allowed():
    """{room: rooms that it may import} as the page's table says."""
    rows = re.findall(r"^\| `(\w+)/` \|.*\| ?([^|]*?) ?\|$", PAGE, re.MULTILINE)
    return {room: set(re.findall(r"`(\w+)/`", cell)) for room, cell in rows}


def imports_of(path):
    """Rooms of the package that a module imports, inside functions too."""
    parts = path.relative_to(PACKAGE).parts
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = [*parts[: len(parts) - node.level], *((node.module or "").split(".") if node.module else [])]
            names = base[:1] or [alias.name for alias in node.names]
            yield from (name for name in names if (PACKAGE / name).is_dir())


def test_every_room_imports_only_what_stands_below_it():
    rules = allowed()
    rooms = {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert rules.keys() == rooms
    wrong = {
        (str(path.relative_to(PACKAGE)), name)
        for room in rooms
        for path in (PACKAGE / room).rglob("*.py")
        for name in imports_of(path)
        if name != room and name not in rules[room]
    }
    assert not wrong


def test_the_rules_have_no_circle():
    rules, done = allowed(), set()
    while len(done) < len(rules):
        ready = {room for room, below in rules.items() if room not in done and below <= done}
        assert ready, f"a circle among {rules.keys() - done}"
        done |= ready


def test_few_modules_lie_loose():
    assert len(list(PACKAGE.glob("*.py"))) <= MODULES_AT_THE_TOP


def functions_and_classes():
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                yield path.relative_to(PACKAGE), node


def test_solvers_and_equations_know_no_scene():
    """Neither by import nor by name."""
    for room in ("equations", "solvers", "laws", "mesh"):
        for path in (PACKAGE / room).rglob("*.py"):
            names = {node.id for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Name)}
            assert not names & {"scene", "Scene"}, path


def test_only_one_module_asks_for_a_version_of_dolfinx():
    asking = re.compile(r"dolfinx\.__version__|hasattr\((dolfinx|basix|ufl|fem)\b|import basix\.ufl")
    found = {p.name for p in PACKAGE.rglob("*.py") if asking.search(p.read_text()) and p.name != "outcome.py"}
    assert found <= {"fenicsx.py"}  # outcome.py writes the version into result.json


def test_classes_and_parameter_lists_are_short():
    """What is longer holds more than one thing: a class goes apart, and arguments that belong together become a dataclass."""
    for path, node in functions_and_classes():
        if isinstance(node, ast.ClassDef):
            assert node.end_lineno - node.lineno < LONGEST_CLASS, f"{path}: {node.name}"
            continue
        names = [one.arg for one in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)]
        assert len(names) - (names[:1] in (["self"], ["cls"])) <= MOST_PARAMETERS, f"{path}: {node.name}"
