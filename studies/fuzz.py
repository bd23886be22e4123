"""Mutated scenes, studies, packings, series and meshes: each must end in a run or in a refusal of one line. Run: make fuzz-test
(an hour and a half for 10 000 on one core; --cases for fewer).

Lines of a small sound file are deleted, doubled, garbled, or given other values, units and magnitudes; bytes of packings,
series and meshes are changed, too. The program then runs on it as from the command line, in a process of its own. It is wrong
if it ends with a traceback or by a signal, refuses with other than one line, leaves a folder that is neither empty nor whole,
or takes more than `MOST_SECONDS` of CPU for anything but a run that the input asks for (ten times the steps), which is told.
What takes longer than a minute is stopped as by a user, and must have kept its results.
"""

import argparse
import contextlib
import io
import json
import os
import random
import signal
import tempfile
import time
import traceback
from pathlib import Path

from porousmold.cli import main as command_line

SCENE = """[geometry]
kind = "mold"
length = "1 m"
cavity_height = "50 mm"
[bed]
bead_diameter = "5 mm"
bulk_porosity = 0.4
[wall]
material = "aluminium"
thickness = "3 mm"
[fluid]
material = "air"
[operation]
initial_temperature = "298.15 K"
inlet_temperature = "363.15 K"
pressure_drop = "8 kPa"
end_time = "30 min"
heating_margin = "60 K"
[model]
turbulence = "none"
flow = "plug"
[solver]
axial_cells = 4
cell_growth = 1.6
[output]
fields = false
pictures = false
"""
STUDY = """[study]
scene = "scene.toml"
record = ["heating_time", "mean_power"]
[set]
solver.step_refinement = 0.5
[vary]
wall.thickness = ["2 mm", "3 mm"]
bed.bead_diameter = { from = "4 mm", to = "5 mm", count = 2 }
"""
VALUES = [
    *(
        "0",
        "-1",
        "1",
        "2.5",
        "1e-9",
        "1e9",
        "nan",
        "inf",
        "true",
        "[]",
        "{}",
        '""',
        '"x"',
        '"5 mm"',
        '"5 mm/s"',
        '"20 degC"',
    ),
    *(
        '"300 K"',
        '"1 kPa"',
        '"10 %"',
        '"1 / 0"',
        '"../x.csv"',
        '"pipe"',
        '"full"',
        '"developed"',
        '"thin"',
        '"insulated"',
    ),
    *(
        '"conjugate"',
        '"two-temperature"',
        '"one-temperature"',
        '"frp"',
        '"hunt-tien"',
        '"constant"',
        "'''a\nb'''",
        '"\\u0000"',
    ),
]
DONE, REFUSED, FAILED, INTERRUPTED = 0, 2, 3, 130
LONGEST, MOST_SECONDS = 60, 20.0
FIELD_CASES = Path(__file__).parent.parent / "tests" / "field_cases"
PACKINGS = (
    *(
        "02-triclinic-scaled-dump/scaled.dump",
        "02-triclinic-scaled-dump/triclinic.dump",
        "03-yade-id-format/yade_id.txt",
    ),
    *(
        "20-csv-packings/exa.xyz",
        "20-csv-packings/semi.csv",
        "20-csv-packings/paraview.csv",
        "20-csv-packings/plain.dump.gz",
    ),
)
MESHES = ("11-gmsh-users/v41.msh", "11-gmsh-users/dupnodes.msh")
SERIES = ("good", "semi_comma", "tab_comma", "stamp", "utf16", "idx", "parens", "trailing", "minutes2", "nan")


def mutated(text, draw):
    """The text with one to three mutations."""
    lines = text.splitlines()
    for _ in range(draw.randint(1, 3)):
        number = draw.randrange(len(lines)) if lines else 0
        line = lines[number] if lines else ""
        kind = draw.choice(["delete", "double", "garble", "value", "value", "scale", "scale", "name"])
        name, equals, _ = line.partition(" = ")
        if kind == "delete" and lines:
            del lines[number]
        elif kind == "double":
            lines.insert(number, line)
        elif kind == "garble" and line:
            place = draw.randrange(len(line))
            lines[number] = line[:place] + draw.choice(["", "#", '"', "=", "é", "\t", "[", "9"]) + line[place + 1 :]
        elif kind == "name" and equals:
            lines[number] = name[::-1] + equals + line.partition(" = ")[2]
        elif kind == "value" and equals:
            lines[number] = f"{name} = {draw.choice(VALUES)}"
        elif kind == "scale":
            digits = [i for i, character in enumerate(line) if character.isdigit()]
            if digits:
                place = draw.choice(digits)
                lines[number] = line[:place] + draw.choice(["0", "1", "7", "-3", "10", "0.1"]) + line[place + 1 :]
    return "\n".join(lines) + "\n"


def damaged(content: bytes, draw: random.Random) -> bytes:
    """The bytes of a file with one to three places cut, doubled, or replaced."""
    for _ in range(draw.randint(1, 3)):
        place = draw.randrange(max(len(content), 1))
        length = draw.choice((1, 1, 3, 20, 500))
        kind = draw.choice(("cut", "double", "replace", "replace", "end"))
        if kind == "end" and draw.random() < 0.3:
            content = content[:place]
        elif kind == "cut":
            content = content[:place] + content[place + length :]
        elif kind == "double":
            content = content[: place + length] + content[place:]
        else:
            new = draw.choice(
                (b"", b"-", b"9", b"1e300", b"nan", b"\n", b",", b" ", b"\x00", b"\xff", b"0", b"inf", b"\t", b";")
            )
            content = content[:place] + new + content[place + 1 :]
    return content


def case_of(number: int, here: Path) -> list[str]:
    """Write the files of a case into a folder; the program's arguments."""
    draw = random.Random(number)
    kind = ("scene", "study", "packing", "series or mesh")[number % 4]
    scene = here / "scene.toml"
    scene.write_text(mutated(SCENE, draw) if kind == "scene" else SCENE, encoding="utf-8")
    if kind == "scene":
        return ["run", str(scene), "--quiet", "--out", str(here / "out")]
    if kind == "study":
        study = here / "study.toml"
        study.write_text(mutated(STUDY, draw), encoding="utf-8")
        return ["study", str(study), "--quiet", "--out", str(here / "out")]
    if kind == "packing":
        source = FIELD_CASES / draw.choice(PACKINGS)
        path = here / source.name
        path.write_bytes(damaged(source.read_bytes(), draw))
        container = ["--container", "cylinder", "--diameter", "60 mm", "--bead-diameter", "5 mm"]
        return ["porosity", str(path), *container, "--quiet", "--out", str(here / "profile.csv")]
    if number % 8 == 3:
        source = FIELD_CASES / "08-logger-csv" / f"{draw.choice(SERIES)}.csv"
        (here / "series.csv").write_bytes(damaged(source.read_bytes(), draw))
        return ["check", str(scene), "--set", "operation.inlet_temperature=series.csv"]
    source = FIELD_CASES / draw.choice(MESHES)
    (here / source.name).write_bytes(damaged(source.read_bytes(), draw))
    scene.write_text((source.parent / "scene.toml").read_text(encoding="utf-8"), encoding="utf-8")
    return ["check", str(scene), "--set", f"geometry.mesh={source.name}"]


def apart(arguments: list[str], here: Path) -> tuple[int, str, float]:
    """Status (negative: the signal), standard error and CPU seconds of the program in a process of its own."""
    told, begun = here / "told", time.monotonic()
    child = os.fork()
    if not child:
        status, errors = 1, "no end"
        try:
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
            os.dup2(os.open(here / "native", os.O_WRONLY | os.O_CREAT), 2)
            status, errors = ended(arguments)
        finally:
            told.write_text(errors, encoding="utf-8")
            os._exit(status or 0)
    _, status, usage = os.wait4(child, 0)
    errors = told.read_text(encoding="utf-8") if told.is_file() else ""
    code = os.waitstatus_to_exitcode(status)
    if code in (-signal.SIGINT, -signal.SIGKILL) and time.monotonic() - begun > LONGEST:
        code = INTERRUPTED  # by its own watchdog, as it did not look at the signal in time
    return code, errors, usage.ru_utime + usage.ru_stime


class TooLongError(Exception):
    """A case took so long that even the stop asked for did not come through."""


def ended(arguments):
    """(status, standard error) of the program, stopped after `LONGEST` seconds."""

    def give_up(*_):
        raise TooLongError

    def ask_to_stop(*_):
        signal.signal(signal.SIGALRM, give_up)
        signal.alarm(5 * LONGEST)
        os.kill(os.getpid(), signal.SIGTERM)

    errors = io.StringIO()
    signal.signal(signal.SIGALRM, ask_to_stop)
    signal.alarm(LONGEST)
    try:
        with contextlib.redirect_stderr(errors), contextlib.redirect_stdout(io.StringIO()):
            status = command_line(arguments)
    except SystemExit as end:
        status = end.code
    except TooLongError:
        status = INTERRUPTED
    except Exception:
        traceback.print_exc(file=errors)
        status = 1
    finally:
        signal.alarm(0)
    return status, errors.getvalue()


def wrong(status, errors, out):
    """What is wrong with how a case ended; empty if nothing is."""
    if status not in (DONE, REFUSED, FAILED, INTERRUPTED) or "Traceback" in errors:
        return f"status {status}"
    if status == REFUSED and sum(line.startswith("porousmold: ") for line in errors.splitlines()) != 1:
        return "refusal of other than one line"
    for folder in [out, *out.glob("*/")] if out.is_dir() else []:
        names = {path.name for path in folder.iterdir() if path.is_file() and not path.name.startswith(".")}
        if [path for path in folder.iterdir() if path.name.endswith(".part")]:
            return "half-written file"
        if "history.csv" in names and not {"result.json", "scene.toml"} <= names:
            return "half-written folder"
        if status == REFUSED and "result.json" in names and folder == out:
            return "refused, but written"
        if "result.json" in names:
            json.loads((folder / "result.json").read_text())
    return ""


def main():
    """Mutate and run; status 1 if a case went wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0, help="number of the first case")
    options, counts, bad, slowest = parser.parse_args(), {}, 0, 0.0
    import porousmold.packing.cli
    import porousmold.simulation.checking  # noqa: F401 - once, before processes are forked

    for number in range(options.first, options.first + options.cases):
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as directory:  # a killed child may still write
            here = Path(directory)
            arguments = case_of(number, here)
            status, errors, seconds = apart(arguments, here)
            found = wrong(status, errors, here / "out")
            if seconds > MOST_SECONDS and status in (DONE, INTERRUPTED):
                print(f"case {number}: long: {seconds:.0f} s of CPU, status {status}", flush=True)
            elif seconds > MOST_SECONDS:
                found = found or f"{seconds:.0f} s of CPU"
            counts[status], slowest = counts.get(status, 0) + 1, max(slowest, seconds)
            if found:
                bad += 1
                print(f"case {number}: {found}: {arguments}\n{errors}", flush=True)
        if (number + 1) % 50 == 0:
            text = f"{number + 1} inputs: statuses {dict(sorted(counts.items()))}, {bad} wrong, slowest {slowest:.1f} s of CPU"
            print(text, flush=True)
    return int(bad > 0)


if __name__ == "__main__":
    raise SystemExit(main())
