"""Consistency checks of the keys of a scene: a violated rule raises an `InputError` that names a key."""

from typing import TYPE_CHECKING, Any, Literal

from ..errors import InputError
from ..laws.material_library import SOLIDS
from ..laws.porosity import POROSITY_MODELS
from .air_loop import has_air_loop, is_round, read_curve
from .geometries import GEOMETRIES, dimension_of
from .phases import DRIVES, check_phases, has_phases
from .schema import KEYS
from .sensors import sensor_names
from .series import TimeSeries
from .tolerances import tolerance_of

if TYPE_CHECKING:
    from .scene import Scene

ASKED: tuple[Literal["within", "above", "below", "spread", "cured"], ...] = (
    "within",
    "above",
    "below",
    "spread",
    "cured",
)
"""What a target may ask for."""
RESERVED_PLACES = ("wall", "bed_side", "bed")
RESERVED_NAMES = (*RESERVED_PLACES, "fluid", "beads", "temperature")
"""Places that every scene has, whose names no layer can have."""
SAME_LENGTH = 1e-6
"""Relative difference of two lengths that rounding explains."""
SMALLEST_RATIO = 10.0
"""Bead diameters that a bed is wide at least."""


def check_together(scene: "Scene") -> None:
    """Every rule, in the order in which a user would fill in the file."""
    for rule in (
        _geometry,
        _drive,
        _air_loop,
        _flow_and_mesh,
        _wall,
        _layers,
        _cure,
        _bed,
        _moving_beads,
        _series,
        _temperatures,
        _outer_wall,
        _solver,
        _liquid,
        _targets,
        _tolerances,
        _output,
        _heated_place,
        _sensors,
        _state,
    ):
        rule(scene)


def _need(scene: "Scene", table: str, name: str) -> None:
    if getattr(getattr(scene, table), name) is None:
        raise InputError(f"{table}.{name}", None, f"is missing; {KEYS[table][name].meaning}", scene.source)


def _refuse(scene: "Scene", full_name: str, allowed: str) -> None:
    table, name = full_name.split(".")
    raise InputError(full_name, getattr(getattr(scene, table), name), allowed, scene.source)


def _geometry(scene: "Scene") -> None:
    _need(scene, "geometry", "kind")
    kind = scene.geometry.kind
    for name in GEOMETRIES[kind].needed:
        _need(scene, "geometry", name)
    for full_name in GEOMETRIES[kind].foreign:
        if scene.is_given(full_name):
            _refuse(scene, full_name, f"has no place in a {kind}")
    _need(scene, "bed", "bead_diameter")
    if scene.geometry.parts != 1 and scene.geometry.symmetry != "none":
        _refuse(scene, "geometry.parts", "must go with geometry.symmetry 'none'")
    if scene.geometry.width is None and scene.geometry.sides != "wall":
        _refuse(scene, "geometry.sides", "has no meaning without geometry.width")
    _need(scene, "operation", "initial_temperature")
    if scene.operation.initial_state is not None and any(
        _cures(scene, layer.material) for layer in scene.layers.values()
    ):
        raise InputError(
            "operation.initial_state",
            None,
            "knows no degree of cure: it has no place with a layer that cures",
            scene.source,
        )
    if has_phases(scene):
        return
    if scene.operation.programme is None:
        _need(scene, "operation", "inlet_temperature")
    elif scene.is_given("operation.inlet_temperature"):
        allowed = "cannot be combined with [[operation.programme]]"
        raise InputError("operation.inlet_temperature", None, allowed, scene.source)


def _drive(scene: "Scene") -> None:
    operation = scene.operation
    check_phases(scene)
    if has_phases(scene):
        return
    drives = [name for name in DRIVES if getattr(operation, name) is not None]
    if operation.blower is not None or operation.blower_pressure is not None:
        _blower(scene, drives)
        return
    if len(drives) != 1:
        given = " and ".join(f"operation.{name}" for name in drives) or "operation.pressure_drop"
        names = ", ".join(f"operation.{name}" for name in DRIVES)
        raise InputError(given, None, f"exactly one of {names} must be given", scene.source)
    drive = getattr(operation, drives[0])
    if len(drive.values) == 1 and (drive.values[0] < 0.0 or (drive.values[0] == 0.0 and drives[0] != "pressure_drop")):
        allowed = f"must be {'>=' if drives[0] == 'pressure_drop' else '>'} 0, but in a time series or a phase"
        raise InputError(f"operation.{drives[0]}", drive.values[0], allowed, scene.source)
    if not any(drive.values) and len(drive.values) > 1 and drives[0] != "pressure_drop":
        raise InputError(f"operation.{drives[0]}", drive.source, "must not be 0 all the time", scene.source)
    if scene.model.flow_update == "frozen" and drive.breakpoints:
        _refuse(scene, "model.flow_update", f"must be 'quasi-steady' with a time series as operation.{drives[0]}")
    limit = 10.0 * operation.outlet_pressure
    if operation.pressure_drop is not None and max(abs(value) for value in operation.pressure_drop.range) > limit:
        allowed = f"must be <= 10 x operation.outlet_pressure ({limit:g} Pa)"
        raise InputError("operation.pressure_drop", operation.pressure_drop.range[1], allowed, scene.source)


def _blower(scene: "Scene", drives: list[str]) -> None:
    operation, model = scene.operation, scene.model
    if drives:
        raise InputError(f"operation.{drives[0]}", None, "cannot be combined with a blower", scene.source)
    if operation.blower is not None:
        for name in ("blower_pressure", "blower_flow"):
            if getattr(operation, name) is not None:
                _refuse(scene, f"operation.{name}", "cannot be combined with operation.blower, a file")
        read_curve(operation.blower)
    elif operation.blower_flow is None:
        _need(scene, "operation", "blower_flow")
    if model.flow_update == "transient":
        _refuse(scene, "model.flow_update", "must be 'quasi-steady' or 'frozen' with a blower")


def _air_loop(scene: "Scene") -> None:
    operation = scene.operation
    if operation.blower_flow is not None and operation.blower_pressure is None:
        _need(scene, "operation", "blower_pressure")
    if operation.duct_resistance and operation.blower is None and operation.blower_pressure is None:
        _refuse(scene, "operation.duct_resistance", "has no meaning without a blower")
    if operation.mold_width is not None and is_round(scene):
        _refuse(scene, "operation.mold_width", "does not apply to a pipe")
    if not has_air_loop(scene):
        for name in ("fresh_temperature", "mold_width"):
            if getattr(operation, name):
                _refuse(scene, f"operation.{name}", "has no meaning without a blower, a heater or recirculation")
        return
    if scene.model.flow_update == "transient":
        _refuse(scene, "model.flow_update", "must not be 'transient' with a heater or recirculation")
    if dimension_of(scene.geometry) == 3 and operation.mold_width is not None:
        _refuse(scene, "operation.mold_width", "has no place in three dimensions")


def _flow_and_mesh(scene: "Scene") -> None:
    model, geometry = scene.model, scene.geometry
    anywhere = geometry.width is not None or geometry.kind == "mesh"
    if anywhere and model.flow == "plug":
        what = "with geometry.width" if geometry.kind != "mesh" else "for a mesh, which has no axial stations"
        _refuse(scene, "model.flow", f"must be 'full' or 'developed' {what}")
    if anywhere and model.flow == "developed":
        for key, needed in (("model.rev_terms", "off"), ("operation.bead_velocity", 0.0)):
            table, name = key.split(".")
            if getattr(getattr(scene, table), name) != needed:
                _refuse(
                    scene,
                    key,
                    f"must be {needed!r} with model.flow 'developed' in three dimensions or a mesh of your own",
                )
    if model.flow_update == "transient" and model.flow != "full":
        _refuse(scene, "model.flow_update", "must go with model.flow 'full'")
    if model.bead_modes is not None:
        for name, value in (("energy", "one-temperature"), ("flow_update", "transient")):
            if getattr(model, name) == value:
                _refuse(scene, "model.bead_modes", f"cannot be combined with model.{name} {value!r}")


def _wall(scene: "Scene") -> None:
    model, operation = scene.model, scene.operation
    if scene.geometry.kind == "mesh":
        if model.wall != "conjugate":
            _refuse(scene, "model.wall", "must be 'conjugate' for a mesh, which has its own wall")
        if scene.wall.thickness is not None:
            _refuse(scene, "wall.thickness", "has no place in a mesh, which has its own wall")
    elif model.wall in ("conjugate", "thin") and scene.wall.layer is None:
        _need(scene, "wall", "thickness")
    if (model.wall == "fixed-temperature") != (operation.wall_temperature is not None):
        allowed = "must be given with model.wall 'fixed-temperature', and only then"
        raise InputError("operation.wall_temperature", None, allowed, scene.source)


def _layers(scene: "Scene") -> None:
    wall, model, is_mesh = scene.wall, scene.model, scene.geometry.kind == "mesh"
    _opposite_wall(scene)
    if not scene.layers:
        return
    if model.wall != "conjugate":
        _refuse(scene, "model.wall", "must be 'conjugate' with layers of the wall")
    for name in ("material", "thickness", "density", "heat_capacity", "conductivity"):
        if wall.layer is not None and scene.is_given(f"wall.{name}"):
            _refuse(scene, f"wall.{name}", "cannot be combined with [[wall.layer]]")
    if wall.layer is not None and scene.is_given("solver.wall_cells"):
        _refuse(scene, "solver.wall_cells", "cannot be combined with [[wall.layer]]: set its cells")
    names: dict[str, str] = {}
    outermost = [f"wall.{name}[{len(getattr(wall, name) or ())}]" for name in ("layer", "opposite_layer")]
    for place, layer in scene.layers.items():
        for name in ("material",) if is_mesh else ("material", "thickness"):
            if getattr(layer, name) is None:
                of_layer = f" (of {layer.name or layer.material})" if layer.name or layer.material else ""
                raise InputError(f"{place}.{name}", None, f"is missing{of_layer}", scene.source)
        for name in ("thickness", "cells"):
            if is_mesh and getattr(layer, name) is not None:
                raise InputError(f"{place}.{name}", getattr(layer, name), "is the mesh's", scene.source)
        if layer.contact_resistance and (is_mesh or place in outermost):
            allowed = "needs a layer behind it" if not is_mesh else "has no place in a mesh: draw a thin layer"
            raise InputError(f"{place}.contact_resistance", layer.contact_resistance, allowed, scene.source)
        name = layer.name or layer.material
        if name in (*names, *RESERVED_NAMES):
            holder = f": {names[name]} has it" if name in names else ": it is the program's"
            raise InputError(f"{place}.name", name, f"must be a name of its own{holder}", scene.source)
        names[name] = place


def _opposite_wall(scene: "Scene") -> None:
    geometry, is_whole = scene.geometry, scene.geometry.cavity == "whole"
    if is_whole and not scene.wall.opposite_layer:
        _refuse(scene, "geometry.cavity", "needs the other wall's layers, [[wall.opposite_layer]]")
    if scene.wall.opposite_layer and not is_whole:
        _refuse(scene, "geometry.cavity", "must be 'whole' with [[wall.opposite_layer]]: half a cavity has equal walls")
    if is_whole and geometry.width is not None:
        _refuse(scene, "geometry.width", "has no place with geometry.cavity 'whole', which is a plane model")


def _cures(scene: "Scene", material: str | None) -> bool:
    return getattr(scene.materials.get(material or "", SOLIDS.get(material or "")), "cure", None) is not None


def _cure(scene: "Scene") -> None:
    layers = [layer.material for layer in scene.layers.values()]
    if _cures(scene, scene.bed.bead_material):
        _refuse(scene, "bed.bead_material", "must not cure: only the wall and its layers do")
    plain = not scene.wall.layer and _cures(scene, scene.wall.material)
    if plain and scene.model.wall != "conjugate":
        _refuse(scene, "model.wall", "must be 'conjugate' with a material that cures")
    if (plain or any(_cures(scene, name) for name in layers)) and scene.model.flow_update == "transient":
        _refuse(scene, "model.flow_update", "must not be 'transient' with a material that cures")


def _bed(scene: "Scene") -> None:
    geometry, bed, limit = scene.geometry, scene.bed, POROSITY_MODELS[scene.bed.porosity_model].largest_bulk_porosity
    if bed.porosity_profile is None and bed.bulk_porosity > limit:
        _refuse(scene, "bed.bulk_porosity", f"must be <= {limit:g} with porosity_model {bed.porosity_model!r}")
    if bed.porosity_profile is not None:
        for name in ("bulk_porosity", "porosity_model"):
            if getattr(bed, name) != KEYS["bed"][name].default:
                _refuse(scene, f"bed.{name}", "has no place beside bed.porosity_profile, which is used instead")
    if bed.conductivity_profile is not None:
        for name in ("model.bead_conduction", "bed.emissivity", "bed.contact_flattening"):
            if scene.is_given(name):
                _refuse(scene, name, "has no place beside bed.conductivity_profile, which is used instead")
    if scene.model.rev_terms != "off" and bed.porosity_profile is None:
        _refuse(scene, "model.rev_terms", "needs bed.porosity_profile: the porosity models give no phi_A")
    least = SMALLEST_RATIO * bed.bead_diameter
    for name in GEOMETRIES[geometry.kind].widths:
        width = getattr(geometry, name)
        if width is None or (name == "width" and geometry.sides == "symmetry"):
            continue
        if width < least * (1 - 1e-9) and not bed.allow_small_ratio:
            allowed = f"must be at least {SMALLEST_RATIO:g} bead diameters ({least:g} m)"
            _refuse(scene, f"geometry.{name}", f"{allowed}, or set bed.allow_small_ratio = true")
        if bed.bead_diameter >= width:
            _refuse(scene, "bed.bead_diameter", f"must be smaller than geometry.{name}")
        if scene.solver.first_cell is not None and scene.solver.first_cell >= width / 2:
            _refuse(scene, "solver.first_cell", f"must be < {width / 2:g} m, half the bed")


def _moving_beads(scene: "Scene") -> None:
    operation, model = scene.operation, scene.model
    moves = operation.bead_velocity != 0.0
    if moves != (operation.bead_inlet_temperature is not None):
        allowed = "must be given with operation.bead_velocity, and only then"
        raise InputError("operation.bead_inlet_temperature", None, allowed, scene.source)
    if not moves:
        return
    if scene.geometry.kind == "mesh":
        _refuse(scene, "operation.bead_velocity", "has no place in a mesh of your own: beads move along straight beds")
    if model.bead_modes is not None:
        _refuse(
            scene, "model.bead_modes", "cannot be combined with operation.bead_velocity: moving beads are isothermal"
        )
    for name, needed in (
        ("energy", "two-temperature"),
        ("flow_update", "quasi-steady or frozen"),
        ("rev_terms", "off"),
    ):
        if getattr(model, name) in ("one-temperature", "transient", "consistent", "as-published"):
            _refuse(scene, f"model.{name}", f"must be {needed!r} with operation.bead_velocity")


def _series(scene: "Scene") -> None:
    """No series begins when the run is over: its times would be those of a clock or a calendar."""
    for name, series in series_of(scene).items():
        begins, end = series.times[0], scene.operation.end_time
        if len(series.times) > 1 and begins >= end:
            allowed = (
                f"begins at {begins:.10g} s, after the run's end at {end:g} s: let its times count from the run's start, "
                'or give { file = "...", time_offset = "first" }'
            )
            raise InputError(name, series.source, allowed, scene.source)


def series_of(scene: "Scene") -> dict[str, TimeSeries]:
    """Every `TimeSeries` of a scene's operation, by the name of its key."""
    return {
        f"operation.{name}": value
        for name in KEYS["operation"]
        if isinstance(value := getattr(scene.operation, name, None), TimeSeries)
    }


def _temperatures(scene: "Scene") -> None:
    operation = scene.operation
    first = (operation.initial_temperature,) if scene.start is None else scene.start.range
    difference = max(abs(value - one) for value in operation.inlet_temperature.values for one in first)
    if _is_heated_otherwise(scene):
        return
    if difference == 0.0:
        allowed = "is operation.initial_temperature: there is nothing to heat or to cool"
        raise InputError("operation.inlet_temperature", operation.initial_temperature, allowed, scene.source)
    if operation.heating_margin >= difference:
        allowed = f"must be < {difference:g} K, the difference of inlet and initial temperature"
        _refuse(scene, "operation.heating_margin", allowed)


def _is_heated_otherwise(scene: "Scene") -> bool:
    """Whether heat comes from elsewhere than with the fluid: beads, wall, surroundings or sources."""
    operation, layers = scene.operation, scene.layers.values()
    series = (
        *(operation.ambient_temperature, operation.wall_temperature, operation.bead_inlet_temperature),
        operation.return_temperature,
    )
    others = [value for one in series if one is not None for value in one.values]
    return (
        any(value != operation.initial_temperature for value in others)
        or operation.outer_heat_flux is not None
        or any(layer.heat_source is not None or _cures(scene, layer.material) for layer in layers)
        or (not scene.wall.layer and _cures(scene, scene.wall.material))
    )


def _outer_wall(scene: "Scene") -> None:
    operation = scene.operation
    given = (operation.outer_heat_flux, operation.outer_coefficient, operation.outer_emissivity)
    if scene.model.wall in ("insulated", "fixed-temperature") and any(one is not None for one in given):
        _refuse(scene, "model.wall", "excludes operation.outer_heat_flux, outer_coefficient and outer_emissivity")
    if operation.outer_heat_flux is None and operation.outer_heat_flux_factor != 1.0:
        _refuse(scene, "operation.outer_heat_flux_factor", "has no meaning without operation.outer_heat_flux")
    if operation.outer_emissivity is not None and operation.ambient_temperature is None:
        _refuse(scene, "operation.outer_emissivity", "and operation.ambient_temperature must be given together")
    exchanges = operation.outer_coefficient is not None or operation.outer_emissivity is not None
    if exchanges != (operation.ambient_temperature is not None):
        _refuse(scene, "operation.outer_coefficient", "and operation.ambient_temperature must be given together")


def _solver(scene: "Scene") -> None:
    if scene.solver.accuracy is not None:
        for name in ("mesh_refinement", "axial_refinement", "step_refinement"):
            if scene.is_given(f"solver.{name}"):
                _refuse(scene, f"solver.{name}", "is chosen by solver.accuracy")


def _liquid(scene: "Scene") -> None:
    if not scene.is_given("fluid.density"):
        return
    for name in ("viscosity", "heat_capacity", "conductivity"):
        if not scene.is_given(f"fluid.{name}"):
            raise InputError(f"fluid.{name}", None, "is missing: a liquid needs all four properties", scene.source)


def _targets(scene: "Scene") -> None:
    layers = {layer.name or layer.material: layer for layer in scene.layers.values()}
    names: list[str] = []
    for number, target in enumerate(scene.target.list or (), start=1):
        key = f"target[{number}]"
        asked = [name for name in ASKED if getattr(target, name) is not None]
        if len(asked) != 1:
            raise InputError(key, None, f"needs exactly one of {', '.join(ASKED)}", scene.source)
        known = [*RESERVED_PLACES, *layers, *sensor_names(scene.geometry.sensors)]
        if target.place not in known:
            raise InputError(f"{key}.place", target.place, f"must be one of {', '.join(known)}", scene.source)
        if scene.model.wall in ("insulated", "fixed-temperature") and target.place == "wall":
            raise InputError(f"{key}.place", "wall", f"has no place with model.wall {scene.model.wall!r}", scene.source)
        if asked == ["cured"]:
            is_plain = target.place == "wall" and not scene.wall.layer
            material = scene.wall.material if is_plain else getattr(layers.get(target.place), "material", None)
            if not _cures(scene, material):
                allowed = "must be the name of a layer whose material cures"
                raise InputError(f"{key}.place", target.place, allowed, scene.source)
        name = target_name(target)
        if name in names:
            raise InputError(f"{key}.name", name, "must be a name of its own", scene.source)
        names.append(name)


def target_name(target: Any) -> str:
    """The name of a target, by default of its place and what it asks for."""
    return target.name or f"{target.place} {next(name for name in ASKED if getattr(target, name) is not None)}"


def _state(scene: "Scene") -> None:
    state, length = scene.operation.initial_state, scene.geometry.length
    if state is not None and length is not None and abs(state.length / length - 1.0) > SAME_LENGTH:
        allowed = f"is of a bed of {state.length:.6g} m: geometry.length is {length:g} m"
        raise InputError("operation.initial_state", str(state.folder), allowed, scene.source)


def _sensors(scene: "Scene") -> None:
    for name in sensor_names(scene.geometry.sensors):
        if name in RESERVED_PLACES:
            _refuse(
                scene, "geometry.sensors", f"has a sensor {name!r}: that is the name of a place that every scene has"
            )


def _heated_place(scene: "Scene") -> None:
    layers = [layer.name or layer.material for layer in scene.layers.values()]
    if scene.operation.heated_place not in (known := [*RESERVED_PLACES, *layers]):
        _refuse(scene, "operation.heated_place", f"must be one of {', '.join(known)}")


def _output(scene: "Scene") -> None:
    if scene.output.every is not None and scene.output.times is not None:
        _refuse(scene, "output.every", "cannot be combined with output.times")


def _tolerances(scene: "Scene") -> None:
    for name, value in scene.tolerance:
        if scene.is_given(f"tolerance.{name}"):
            tolerance_of(name, value, scene.source)
