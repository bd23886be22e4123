"""How a user's own laws are registered, and tried before anything is computed with them.

A law must take floats, numpy arrays and UFL expressions: use `porousmold.laws.functions` for exp, sqrt, maximum and the like.
Each is called with samples of its range when it is registered; one that raises, gives another shape, no finite number or one of
the wrong sign is refused with one line (`InputError`) that names it, as is one whose arguments have the right names in another
order, and a property in another unit than the SI's.
"""

import inspect
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
import ufl

from ..arrays import Floats
from ..errors import InputError, first_line
from ..files.units import to_si
from .conductivity import BEAD_CONDUCTION_LAWS, DISPERSION_LAWS, Anisotropic, BeadConduction, Dispersion, LocalBed
from .drag import DRAG_LAWS, DragLaw
from .functions import Value
from .material_library import FLUIDS, SOLIDS
from .materials import Fluid, Solid
from .nusselt import NUSSELT_CORRELATIONS, REST, NusseltCorrelation
from .porosity import POROSITY_MODELS, PorosityModel
from .turbulence_models import TURBULENCE_MODELS, LocalFlow, TurbulenceModel

Function = Callable[..., Value]
Decorator = Callable[[Function], Function]
Model = TypeVar("Model", bound=type[TurbulenceModel])
TEMPERATURES = (250.0, 400.0)
"""K, between which a property without a range of its own is tried."""
SAMPLES = 201
"""Of a law, over its range."""
UNITS = {"density": "kg/m^3", "heat_capacity": "J/(kg*K)", "conductivity": "W/(m*K)", "viscosity": "Pa*s"}
"""That properties are computed in."""


def nusselt(name: str, *, reynolds: tuple[float, float], source: str, floor: float | None = REST) -> Decorator:
    """Register f(reynolds, prandtl, porosity) = h d/lambda_f as `model.nusselt = name`; `reynolds` is its range, below `floor`
    it is held constant."""

    def register(function: Function) -> Function:
        law = f"nusselt {name!r}"
        _require_order(law, function, ("reynolds", "prandtl", "porosity"))
        values = _try(law, function, np.geomspace(*reynolds, SAMPLES), 0.7, 0.4)
        _require_positive(law, values, f"over its range of Re, {reynolds[0]:g} to {reynolds[1]:g}")
        NUSSELT_CORRELATIONS.register(name, NusseltCorrelation(function, reynolds, source, floor))
        return function

    return register


def drag(name: str, *, source: str) -> Decorator:
    """Register f(porosity, bead_diameter, density, viscosity, speed) = drag per total volume and per intrinsic velocity
    (kg m-3 s-1), finite at rest, as `model.drag = name`."""

    def register(function: Function) -> Function:
        law = f"drag {name!r}"
        _require_order(law, function, ("porosity", "bead_diameter", "density", "viscosity", "speed"))
        _try(law, function, 0.4, 5e-3, 1.2, 1.8e-5, np.array([0.0, 1e-3]))  # finite at rest
        for porosity, speed in ((0.4, np.geomspace(1e-3, 10.0, SAMPLES)), (np.linspace(0.3, 0.99, SAMPLES), 1.0)):
            values = _try(law, function, porosity, 5e-3, 1.2, 1.8e-5, speed)
            _require_positive(law, values, "for porosities of 0.3 to 0.99 and speeds up to 10 m/s")
        DRAG_LAWS.register(name, DragLaw(function, source))
        return function

    return register


def porosity(name: str, *, source: str, largest_bulk_porosity: float = 1.0) -> Decorator:
    """Register f(wall distance/bead diameter, bulk_porosity) as `bed.porosity_model = name`."""

    def register(function: Function) -> Function:
        distances = np.append(np.linspace(0.0, 10.0, SAMPLES), np.geomspace(10.5, 1000.0, SAMPLES))
        values = _try(f"porosity {name!r}", function, distances, 0.4 * largest_bulk_porosity)
        if np.min(values) <= 0.0 or np.max(values) > 1.0 + 1e-9:
            worst = float(np.min(values)) if np.min(values) <= 0.0 else float(np.max(values))
            raise InputError(f"porosity {name!r}", worst, "must give values in (0, 1] up to 1000 bead diameters")
        POROSITY_MODELS.register(name, PorosityModel(function, source, largest_bulk_porosity))
        return function

    return register


def dispersion(name: str, *, source: str) -> Decorator:
    """Register f(bed) = what the moving fluid mixes, eddies included (W/m/K per total volume, or `Anisotropic`), of a `LocalBed`
    as `model.dispersion = name`."""

    def register(function: Function) -> Function:
        _try_conductivity(f"dispersion {name!r}", function)
        DISPERSION_LAWS.register(name, Dispersion(function, source))
        return function

    return register


def bead_conduction(name: str, *, source: str, whole_bed: bool = False) -> Decorator:
    """Register f(bed) = what the beads conduct (W/m/K per total volume, or `Anisotropic`) of a `LocalBed` as
    `model.bead_conduction = name`; with `whole_bed` it is one number that holds the fluid at rest as well, and reaches the
    wall."""

    def register(function: Function) -> Function:
        if isinstance(_try_conductivity(f"bead conduction {name!r}", function), Anisotropic) and whole_bed:
            raise InputError(f"bead conduction {name!r} law", None, "must give one number with whole_bed")
        BEAD_CONDUCTION_LAWS.register(name, BeadConduction(function, source, whole_bed))
        return function

    return register


def _try_conductivity(law: str, function: Function) -> Value:
    """Call a law with arrays and with UFL numbers; its values for the arrays."""
    places, numbers = np.array([0.0, 1e-4, 1e-2]), (5e-3, 1.2, 1.8e-5, 1007.0, 1.0, 1e-3, 0.026, 2.0, 0.4, 0.4, 300.0)
    found = _called(law, function, LocalBed(0.4, places, *numbers))
    symbols = [ufl.variable(ufl.as_ufl(number)) for number in (0.4, 1e-2, *numbers)]
    _called(f"{law} (with UFL)", function, LocalBed(*symbols))
    for values in found if isinstance(found, Anisotropic) else (found,):
        _check(law, values, 3)
        if np.min(values) < 0.0:
            raise InputError(f"{law} law", float(np.min(values)), "must not be negative")
    return found


def turbulence(name: str) -> Callable[[Model], Model]:
    """Register a frozen dataclass that is a `TurbulenceModel` as `model.turbulence = name`."""

    def register(model: Model) -> Model:
        chosen = model()
        flow = LocalFlow(0.4, 5e-3, np.array([1e-5, 1e-3, 1e-2]), 1.2, 1.8e-5, np.array([0.1, 1.0, 3.0]), 1.0)
        shear = np.array([1e2, 1e4, 1e6])
        values = [np.array([1e-3, 1e-2, 1e-1])] * len(chosen.unknowns)
        law = f"turbulence {name!r}"
        state = _called(law, chosen.state, values, flow, shear)
        viscosity = _called(law, lambda: state.eddy_viscosity)
        _check(law, viscosity, 3)
        for count, found in (
            ("terms", _called(law, chosen.terms, values, flow, state, shear)),
            ("inflow", _called(law, chosen.inflow, flow)),
            ("guess", _called(law, chosen.guess, flow)),
            ("magnitudes", _called(law, chosen.magnitudes, 1.0, 5e-3)),
        ):
            if len(found) != len(chosen.unknowns):
                raise InputError(law, count, f"must have one entry for each of the {len(chosen.unknowns)} unknowns")
        TURBULENCE_MODELS.register(name, chosen)
        return model

    return register


def register(material: Solid | Fluid) -> Solid | Fluid:
    """Register a material under its name."""
    owner = f"{type(material).__name__.lower()} {material.name!r}"
    for name, law in material.laws().items():
        low, high = getattr(law, "temperature_range", TEMPERATURES)
        if not (low > 0.0 and np.isfinite(high)):
            low, high = TEMPERATURES
        temperatures = np.linspace(low, high, SAMPLES)
        arguments: tuple[Any, ...] = (temperatures,)
        if name == "density" and isinstance(material, Fluid):
            arguments = (1e5, temperatures)
        values = _called(owner, law, *arguments) + 0.0 * temperatures
        _check(f"{owner}, {name}", values, len(temperatures))
        if np.min(values) <= 0.0:
            raise InputError(f"{owner}, {name}", float(np.min(values)), f"must be positive from {low:g} to {high:g} K")
        _require_unit(f"{owner}, {name}", getattr(law, "unit", None), UNITS.get(name))
        if not hasattr(law, "source"):
            raise InputError(f"{owner}, {name}", None, "must be a number, or a law with a source (Polynomial, ...)")
    if isinstance(material, Solid):
        SOLIDS.register(material.name, material)
    else:
        FLUIDS.register(material.name, material)
    return material


def _require_unit(owner: str, given: str | None, unit: str | None) -> None:
    """Raise `InputError` for a property that is not told in the unit that it is computed in."""
    if given is None or unit is None:
        return
    if to_si(owner, f"1 {given}", unit) != 1.0:
        raise InputError(owner, given, f"must be in {unit}: its numbers are taken as they are")


def _require_order(law: str, function: Function, names: tuple[str, ...]) -> None:
    """Raise `InputError` for a function whose arguments have the right names in another order."""
    given = tuple(inspect.signature(function).parameters)
    if given != names and sorted(given) == sorted(names):
        raise InputError(f"{law} law", ", ".join(given), f"must have its arguments in the order {', '.join(names)}")


def _require_positive(law: str, values: Floats, where: str) -> None:
    if np.min(values) <= 0.0:
        raise InputError(f"{law} law", float(np.min(values)), f"must be positive {where}")


def _called(law: str, function: Function, *arguments: object) -> Any:
    try:
        return function(*arguments)
    except Exception as error:
        functions = "exp, ln, sqrt, maximum, minimum, where_less and smooth_step"
        hint = (
            f" (in place of numpy's functions: {functions} of porousmold.laws.functions)"
            if "ufunc" in str(error)
            else ""
        )
        raise InputError(f"{law} law", None, f"fails: {first_line(error)}{hint}") from error


def _check(law: str, values: Any, count: int) -> None:
    if np.shape(values) not in ((), (count,)):
        raise InputError(f"{law} law", str(np.shape(values)), f"must give the shape of its argument, ({count},)")
    if not np.all(np.isfinite(np.asarray(values, float))):
        raise InputError(f"{law} law", None, "gives numbers that are not finite")


def _try(law: str, function: Function, *samples: Any) -> Floats:
    """Call a law with arrays and with UFL numbers; its values for the arrays."""
    count = next(len(sample) for sample in samples if np.ndim(sample))
    with np.errstate(all="ignore"):
        values = _called(law, function, *samples)
    _check(law, values, count)
    symbols = [ufl.variable(ufl.as_ufl(float(np.ravel(sample)[-1]))) for sample in samples]
    if getattr(_called(f"{law} (with UFL)", function, *symbols), "ufl_shape", ()):
        raise InputError(f"{law} law", None, "must give one number at a point")
    return np.asarray(values, float)
