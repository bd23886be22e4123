"""mpi4py's MPI. One process that no launcher started looks for no network, which takes Open MPI a third of a second.

Import MPI from here, before anything that imports dolfinx.
"""

import os
import sys

LAUNCHERS = ("OMPI_", "PMIX_", "PMI_", "PRTE_", "SLURM_", "FLUX_", "PALS_", "HYDRA_")
"""Beginnings of the names of variables that launchers give to their processes."""
_ALONE = {
    "OMPI_MCA_ess_singleton_isolated": "1",
    "OMPI_MCA_pml": "ob1",
    "OMPI_MCA_btl": "self",
    "OMPI_MCA_osc": "^ucx",
}

IS_ALONE = "mpi4py.MPI" not in sys.modules and not any(name.startswith(LAUNCHERS) for name in os.environ)
"""Whether this process has no network to talk to others, and so may fork others that work for themselves."""

if not IS_ALONE:
    from mpi4py import MPI
else:
    os.environ.update(_ALONE)
    try:
        from mpi4py import MPI
    finally:
        for _name in _ALONE:  # else an mpirun that this process starts would find no network either
            del os.environ[_name]

__all__ = ["IS_ALONE", "MPI"]
