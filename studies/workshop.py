"""What blower, heater, layers and cure cost: seconds of the workshop's mold beside the same mold with its steel skin alone.

Runs in turn on the same machine; medians of the seconds without compiling, and their ratio.
"""

import statistics

from porousmold import Scene, run

SUPPLY = ("blower", "heater_power", "recirculation", "duct_conductance", "energy_price", "mold_width")
PLAIN = {
    "wall.layer": None,
    "wall.material": "carbon_steel",
    "wall.thickness": "4 mm",
    "target.list": None,
    "operation.pressure_drop": "16 kPa",
    **{f"operation.{name}": None for name in SUPPLY},
}
TURNS = 5


def seconds(scene):
    """(seconds without compiling, end of the run in s)."""
    summary = run(scene).summary
    return summary["wall_seconds"]["total"] - summary["wall_seconds"]["compile"], summary["end_time"]


def main():
    scene = Scene.load("studies/mold/workshop.toml", {"output.fields": False})
    _, end = seconds(scene)  # compiles
    plain = scene.changed({**PLAIN, "operation.end_time": end})
    seconds(plain)
    taken = [(seconds(plain)[0], seconds(scene)[0]) for _ in range(TURNS)]
    without, with_all = (statistics.median(values) for values in zip(*taken, strict=True))
    print(f"steel skin alone {without:.1f} s, the workshop's mold {with_all:.1f} s: {with_all / without:.2f} times")


if __name__ == "__main__":
    main()
