"""porousmold: heating and cooling of bead-filled molds and pipes, volume-averaged, with dolfinx.

from porousmold import Scene, run
result = run(Scene.load("studies/mold/aluminium.toml", {"wall.thickness": "2 mm"}))
print(result.heating_time)
"""

import importlib
import os
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

# Ranks are the parallelism. Threads of the BLAS below them only spin on factors this small (7 times slower when another
# process wants the core); the variable is read when the BLAS is loaded, so it is set before anything imports numpy.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from .errors import InputError, SolveError
from .files.cache_folder import provide_cache

provide_cache()  # dolfinx looks for it when it is imported

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from .laws.conductivity import Anisotropic, LocalBed
    from .laws.extension import bead_conduction, dispersion, drag, nusselt, porosity, register, turbulence
    from .laws.materials import (
        ConstantDensity,
        Fluid,
        IdealGasDensity,
        LiquidDensity,
        LogPolynomial,
        PiecewiseLinear,
        Polynomial,
        Solid,
        SutherlandViscosity,
    )
    from .laws.turbulence_models import LocalFlow, TransportTerms, TurbulenceModel, TurbulentUnknown
    from .scene.scene import Scene
    from .simulation.result import Result

try:
    __version__ = version("porousmold")
except PackageNotFoundError:  # used from the source tree without installation
    __version__ = "0+source"

_SUBPACKAGES = {
    "laws.conductivity": ("Anisotropic", "LocalBed"),
    "laws.extension": ("bead_conduction", "dispersion", "drag", "nusselt", "porosity", "register", "turbulence"),
    "laws.materials": (
        *("ConstantDensity", "Fluid", "IdealGasDensity", "LiquidDensity", "LogPolynomial", "PiecewiseLinear"),
        *("Polynomial", "Solid", "SutherlandViscosity"),
    ),
    "laws.turbulence_models": ("LocalFlow", "TransportTerms", "TurbulenceModel", "TurbulentUnknown"),
    "scene.scene": ("Scene",),
}
"""Where the public names stand: each is imported when it is first asked for, as that takes half a second in all."""
__all__ = [
    "Anisotropic",
    "ConstantDensity",
    "Fluid",
    "IdealGasDensity",
    "InputError",
    "LiquidDensity",
    "LocalBed",
    "LocalFlow",
    "LogPolynomial",
    "PiecewiseLinear",
    "Polynomial",
    "Scene",
    "Solid",
    "SolveError",
    "SutherlandViscosity",
    "TransportTerms",
    "TurbulenceModel",
    "TurbulentUnknown",
    "bead_conduction",
    "dispersion",
    "drag",
    "nusselt",
    "porosity",
    "register",
    "run",
    "turbulence",
]


def __getattr__(name: str) -> Any:
    for room, names in _SUBPACKAGES.items():
        if name in names:
            value = getattr(importlib.import_module(f".{room}", __name__), name)
            globals()[name] = value
            return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def run(scene: "Scene | str | Path | Mapping[str, object]", *arguments: Any, **options: Any) -> "Result":
    """Run a scene and give its result: see `porousmold.simulation.running.run`, which has the same arguments.

    Beside a `Scene` the name of its file will do, or its tables as a dict.
    """
    from . import mpi  # noqa: F401 - before dolfinx
    from .scene.scene import Scene
    from .simulation.running import run as run_scene  # on demand: a scene can be checked without dolfinx

    return run_scene(scene if isinstance(scene, Scene) else Scene.load(scene), *arguments, **options)
