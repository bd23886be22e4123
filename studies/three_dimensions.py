"""Full against locally developed flow, where the bed is not straight or has three dimensions: scenes drawn at random, of five
shapes. Writes docs/three-dimensions.md. Run: make three-dimensions (an hour).

A plane bed below a curved skin, a narrow cavity with side walls, half of a wide tool with a doubly curved skin whose whole ends
are open or that is fed through ports, and a pipe that turns a corner; beads, pressure drop, temperatures, closures, turbulence
and wall are drawn by a Latin hypercube.
"""

import argparse
import re
import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from mpi4py import MPI

from porousmold import InputError, Scene, SolveError, run
from studies.hypercube import draws
from studies.page import Page

MESHES = Path(__file__).parent.parent / "meshes"
PAGE = Path(__file__).parent.parent / "docs" / "three-dimensions.md"
PLANE, CAVITY, CURVED, PORTS, BENT = SHAPES = (
    "plane, curved skin",
    "cavity with side walls",
    "doubly curved skin",
    "the same, fed through ports",
    "pipe that turns a corner",
)
RANGES = {
    "rise": (0.002, 0.02, False),
    "bead_diameter": (1.5e-3, 4.5e-3, True),
    "pressure_drop": (500.0, 3e4, True),
    "inlet_temperature": (330.0, 450.0, False),
    "width": (0.06, 0.2, True),
}
"""Of what is drawn: from, to, and whether evenly in the logarithm."""
CHOICES = {
    "closures": ("thesis", "measured"),
    "turbulence": ("none", "nakayama-kuwahara", "damped-nakayama-kuwahara"),
    "material": ("aluminium", "frp", "stainless_steel"),
    "bead_material": ("ceramic", "glass", "steel"),
}
OPENING = """# Three dimensions, and meshes of one's own

Written by `make three-dimensions`; do not edit.

`model.flow = "developed"` has the developed profile of the local pressure gradient and wall distance everywhere (docs/theory.md):
one scalar equation of the pressure in place of velocity, pressure and turbulence. Left out are the entrance, the inertia of the
fluid where the section changes, and what a corner of two walls adds to the nearer one. Against the full flow on the same cells.
At the edges of ports these are too coarse for both flows, which err to either side (docs/meshes.md): the difference there is
mostly theirs, as `mass_flow_error` of both runs tells.
"""


class Compared(NamedTuple):
    """A scene's answers by both flows, full and developed: heating times and mass flows over each other - 1, what each tells of
    its mass flow's error by cells, and CPU seconds of flow and run."""

    shape: str
    words: str
    time: float
    mass_flow: float
    told: tuple[float | None, float | None]
    flow_seconds: tuple[float, float]
    run_seconds: tuple[float, float]
    unknowns: tuple[int, int]


def drawn_scenes(count: int, folder: Path, seed: int = 37) -> Iterator[tuple[str, str, Scene]]:
    """Shape, words and scene of `count` draws; meshes are written into a folder."""
    for number, drawn in enumerate(draws(RANGES, CHOICES, count, seed)):
        shape = SHAPES[number % len(SHAPES)]
        if shape == PORTS:
            drawn["turbulence"] = "none"  # the full flow's k-epsilon does not converge at ports on these coarse cells
        words = ", ".join(
            f"{name} {value:.3g}" if isinstance(value, float) else str(value) for name, value in drawn.items()
        )
        yield shape, words, Scene(_tables(shape, number, drawn, folder))


def _tables(shape: str, number: int, drawn: dict[str, Any], folder: Path) -> dict[str, Any]:
    tables: dict[str, Any] = {
        "bed": {"bead_diameter": drawn["bead_diameter"], "bead_material": drawn["bead_material"]},
        "wall": {"material": drawn["material"]},
        "operation": {
            "initial_temperature": 298.15,
            "inlet_temperature": drawn["inlet_temperature"],
            "pressure_drop": drawn["pressure_drop"],
            "end_time": 1e5,
        },
        "model": {"closures": drawn["closures"], "turbulence": drawn["turbulence"]},
        "output": {"pictures": False, "fields": False},
    }
    if shape == CAVITY:
        tables["geometry"] = {"kind": "mold", "length": 1.0, "cavity_height": 0.05, "width": drawn["width"]}
        tables["wall"]["thickness"] = 0.003
        return tables | {"solver": {"mesh_refinement": 0.35}}
    file = folder / f"{number}.geo"
    if shape == PLANE:
        text = (MESHES / "curved_mold.geo").read_text()
        file.write_text(re.sub(r"rise = [0-9.]+", f"rise = {drawn['rise']:.6f}", text))
        return tables | {"geometry": {"kind": "mesh", "mesh": str(file), "symmetry": "planar"}}
    file.write_text(_bent_pipe(drawn) if shape == BENT else _wide_tool(drawn, open_ends=shape == CURVED))
    return tables | {"geometry": {"kind": "mesh", "mesh": str(file), "symmetry": "none", "refine_wall": True}}


def _bent_pipe(drawn: dict[str, Any]) -> str:
    """A pipe a third as wide as what is drawn, that turns by an angle which grows with `rise`."""
    text = (MESHES / "bent_pipe.geo").read_text()
    radius, angle = drawn["width"] / 6.0, 30.0 + 7500.0 * drawn["rise"]
    text = text.replace("radius = 0.02;", f"radius = {radius:.6f};").replace(
        "bend = 0.12;", f"bend = {4.0 * radius:.6f};"
    )
    text = text.replace("angle = Pi / 2;", f"angle = {angle:.3f} * Pi / 180;")
    return text.replace("along = 24;", "along = 14;").replace("across = 5;", "across = 3;")


def _wide_tool(drawn: dict[str, Any], *, open_ends: bool) -> str:
    """Half of a tool half as long as `ports_mold.geo`, on fewer cells."""
    text = (MESHES / "ports_mold.geo").read_text()
    text = text.replace("length = 1.2", "length = 0.6").replace("fine = 1;", "fine = 0.35;")
    text = re.sub(r"crown = [0-9.]+", f"crown = {drawn['rise']:.6f}", text)
    text = re.sub(r"(along|across) = (\d+) \* fine", r"\1 = Ceil(\2 * fine)", text)
    text = text.replace("{4 * fine, 8 * fine, 4 * fine, 9 * fine}", "{1, 3, 2, 3}" if open_ends else "{2, 3, 2, 3}")
    if not open_ends:
        return text
    text = re.sub(r" Using (Bump|Progression) [^;]*;", ";", text)  # no ports whose edges want small cells
    for name, end in (("inlet", "end_in"), ("outlet", "end_out")):
        whole = ", ".join(f"{end}_{block}_0" for block in range(4))
        text = re.sub(rf'Surface\("{name}"\) = {{[^}}]*}}', f'Surface("{name}") = {{{whole}}}', text)
    text = re.sub(r'Physical Surface\("second_outlets"\)[^;]*;', "", text)
    return re.sub(r"section_4_0, section_4_1, end_in_0_0[^}]*end_out_3_0,\s*", "section_4_0, section_4_1, ", text)


def compared(shape: str, words: str, scene: Scene) -> Compared | None:
    """Both flows of a scene; None where one fails."""
    results, flows, seconds = [], [], []
    for flow in ("full", "developed"):
        start = time.process_time()
        try:
            results.append(run(scene.changed({"model.flow": flow}), communicator=MPI.COMM_SELF))
        except (InputError, SolveError) as error:
            print(shape, flow, "failed:", error, flush=True)
            return None
        seconds.append(time.process_time() - start)
        flows.append(results[-1].summary["wall_seconds"]["flow"])
    full, developed = results
    if full.heating_time is None or developed.heating_time is None:
        print(shape, "not heated", flush=True)
        return None
    found = Compared(
        shape,
        words,
        developed.heating_time / full.heating_time - 1.0,
        developed.summary["mass_flow_initial"] / full.summary["mass_flow_initial"] - 1.0,
        (full.summary["mass_flow_error"], developed.summary["mass_flow_error"]),
        (flows[0], flows[1]),
        (seconds[0], seconds[1]),
        (full.summary["unknowns"]["flow"], developed.summary["unknowns"]["flow"]),
    )
    print(found, flush=True)
    return found


def write(known: list[Compared], count: int, path: Path) -> None:
    """The page of what was compared, of `count` scenes drawn."""
    page = Page(*OPENING.splitlines())
    page.add(f"{len(known)} of {count} scenes drawn at random were heated by both.", "")
    rows = []
    for shape in SHAPES:
        part = [one for one in known if one.shape == shape]
        if not part:
            continue
        times, flows = ([abs(getattr(one, name)) for one in part] for name in ("time", "mass_flow"))
        ratio = statistics.median(one.flow_seconds[0] / one.flow_seconds[1] for one in part)
        whole = statistics.median(one.run_seconds[0] / one.run_seconds[1] for one in part)
        rows.append([shape, len(part), f"{statistics.median(times):.2%}", f"{max(times):.2%}", f"{statistics.median(flows):.2%}",
                     f"{max(flows):.2%}", f"{ratio:.1f}", f"{whole:.1f}"])  # fmt: skip
    page.table(("shape", "scenes", "heating time, median difference", "largest", "mass flow, median", "largest",
                "flow: full over developed, seconds", "whole run"), rows)  # fmt: skip
    page.add("## Every scene", "")
    page.table(
        ("shape", "what", "heating time", "mass flow", "told of it: full / developed", "unknowns of the flow", "flow, s",
         "whole run, CPU s"),
        [
            [one.shape, one.words, f"{one.time:+.2%}", f"{one.mass_flow:+.2%}",
             " / ".join("-" if error is None else f"{error:.1%}" for error in one.told), *(f"{a:.3g} / {b:.3g}" for a, b in
             (one.unknowns, one.flow_seconds, one.run_seconds))]
            for one in known
        ],
    )  # fmt: skip
    page.write(path)


def main() -> None:
    """Run everything and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--out", type=Path, default=PAGE)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        found = [compared(*drawn) for drawn in drawn_scenes(arguments.count, Path(folder))]
    write([one for one in found if one is not None], arguments.count, arguments.out)


if __name__ == "__main__":
    main()
