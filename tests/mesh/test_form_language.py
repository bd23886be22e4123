"""ufl and ffcx without pkg_resources."""

import subprocess
import sys


def test_a_run_is_ready_without_pkg_resources_which_stays_to_be_had():
    """In a process of its own, as this one may have it from elsewhere; both tell their versions."""
    code = (
        "import sys, porousmold.mpi, porousmold.simulation.running, ffcx, ufl\n"
        "from importlib.metadata import version\n"
        "assert 'pkg_resources' not in sys.modules\n"
        "assert ufl.__version__ == version('fenics-ufl') and ffcx.__version__ == version('fenics-ffcx')\n"
        "try:\n    import pkg_resources\nexcept ImportError:\n    sys.exit()\n"
        "assert pkg_resources.Requirement\n"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert not ended.returncode, ended.stderr
