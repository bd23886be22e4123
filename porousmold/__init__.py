"""porousmold: heating and cooling of bead-filled molds and pipes, volume-averaged, with dolfinx.

from porousmold import Scene, run
result = run(Scene.load("studies/mold/aluminium.toml", {"wall.thickness": "2 mm"}))
print(result.heating_time)
"""

import os
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

# Ranks are the parallelism. Threads of the BLAS below them only spin on factors this small (7 times slower when another
# process wants the core); the variable is read when the BLAS is loaded, so it is set before anything imports numpy.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from .errors import InputError, SolveError
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

if TYPE_CHECKING:
    from .simulation.running import Result

try:
    __version__ = version("porousmold")
except PackageNotFoundError:  # used from the source tree without installation
    __version__ = "0+source"

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


def run(scene: Scene, *arguments: Any, **options: Any) -> "Result":
    """Run a scene and give its result: see `porousmold.simulation.running.run`, which has the same arguments."""
    from .simulation.running import run as run_scene  # on demand: a scene can be checked without dolfinx

    return run_scene(scene, *arguments, **options)
