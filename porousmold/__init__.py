"""porousmold: heating and cooling of bead-filled molds and pipes, volume-averaged, with dolfinx.

from porousmold import Scene, run
result = run(Scene.load("studies/mold/aluminium.toml", wall__thickness="2 mm"))
print(result.heating_time)
"""

import os
from importlib.metadata import PackageNotFoundError, version

# Ranks are the parallelism. Threads of the BLAS below them only spin on factors this small (7 times slower when another
# process wants the core); the variable is read when the BLAS is loaded, so it is set before anything imports numpy.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from .errors import InputError, SolveError
from .scene import Scene

try:
    __version__ = version("porousmold")
except PackageNotFoundError:  # used from the source tree without installation
    __version__ = "0+source"

__all__ = ["InputError", "Scene", "SolveError", "run"]


def run(scene, out=None, communicator=None, progress=None, stop=lambda: False, resume=False, observe=None):
    """Run a scene and give its result: see `porousmold.running.run`."""
    from .running import run as run_scene  # on demand: a scene can be checked without dolfinx

    return run_scene(scene, out, communicator, progress, stop, resume, observe)
