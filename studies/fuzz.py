"""Mutated scene and study files: each must end in a run or in a refusal of one line. Run: make fuzz-test (minutes).

Lines of a small sound scene (or study) are deleted, doubled, garbled, or given other values, units and magnitudes. The program
then runs on it as from the command line. It is wrong if it ends with a traceback, refuses with other than one line, or leaves a
folder that is neither empty nor whole. What takes longer than a minute is stopped as by a user, and must have kept its results.
"""

import argparse
import contextlib
import io
import json
import os
import random
import signal
import tempfile
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
LONGEST = 60


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
    if status == REFUSED and len(errors.strip().splitlines()) != 1:
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
    parser.add_argument("--cases", type=int, default=500)
    cases, counts, bad = parser.parse_args().cases, {}, 0
    for number in range(cases):
        draw, study = random.Random(number), number % 4 == 3
        with tempfile.TemporaryDirectory() as directory:
            here = Path(directory)
            scene, study_file = here / "scene.toml", here / "study.toml"
            scene.write_text(SCENE if study else mutated(SCENE, draw), encoding="utf-8")
            study_file.write_text(mutated(STUDY, draw), encoding="utf-8")
            chosen = ["study", str(study_file)] if study else ["run", str(scene)]
            status, errors = ended([*chosen, "--quiet", "--out", str(here / "out")])
            found = wrong(status, errors, here / "out")
            counts[status] = counts.get(status, 0) + 1
            if found:
                bad += 1
                print(f"case {number}: {found}\n{errors}\n{(study_file if study else scene).read_text()}", flush=True)
        if (number + 1) % 50 == 0:
            print(f"{number + 1} files: statuses {dict(sorted(counts.items()))}, {bad} wrong", flush=True)
    return int(bad > 0)


if __name__ == "__main__":
    raise SystemExit(main())
