"""What in a scene is possible, but looks like a slip: a length in mm given as m, a pressure drop in kPa given as Pa."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .scene import Scene

COLDEST, HOTTEST = 200.0, 1500.0
SMALLEST_PRESSURE_DROP = 20.0
THICKEST_WALL, LARGEST_BEAD, LONGEST_BED = 0.3, 0.1, 30.0


def implausible_values(scene: "Scene") -> list[str]:
    """One sentence for every value that no shop floor has."""
    found = []
    for name, value in scene.operation:
        if name.endswith("temperature") and value is not None:
            lowest, highest = value.range if hasattr(value, "range") else (value, value)
            for number in {lowest, highest}:
                shown = f"operation.{name} is {number:.4g} K, {number - 273.15:.4g} °C"
                if number < COLDEST and not scene.has_unit(f"operation.{name}"):
                    found.append(f"{shown}: is {number:g} meant in °C?")
                if number > HOTTEST:
                    found.append(f"{shown}: few properties are known there, and fewer walls stand it")
    lengths = [("wall.thickness", scene.wall.thickness, THICKEST_WALL)]
    lengths += [(f"{key}.thickness", layer.thickness, THICKEST_WALL) for key, layer in scene.layers.items()]
    lengths += [
        ("bed.bead_diameter", scene.bed.bead_diameter, LARGEST_BEAD),
        ("geometry.length", scene.geometry.length, LONGEST_BED),
    ]
    for name, value, most in lengths:
        if value is not None and value > most:
            found.append(f"{name} is {value:g} m: is {value:g} meant in mm?")
    drop = scene.operation.pressure_drop
    if drop is not None and 0.0 < drop.range[1] < SMALLEST_PRESSURE_DROP:
        found.append(f"operation.pressure_drop is {drop.range[1]:g} Pa: is {drop.range[1]:g} meant in kPa?")
    return found
