"""Settings of all tests, and which of them are slow."""

from pathlib import Path

import pytest
from hypothesis import settings
from mpi4py import MPI  # noqa: F401 - first, so that studies in tests fork no workers (`porousmold.mpi.IS_ALONE`)

# a busy machine is no failure; pytest's own time-out guards against what never ends
settings.register_profile("same-examples", deadline=None, derandomize=True)
settings.register_profile("new-examples", deadline=None, max_examples=1000)  # `make fuzz-test` searches with these
settings.load_profile("same-examples")

SLOW = {
    *("test_acceptance.py", "test_extending.py", "test_model_choices.py", "test_parallel.py", "test_studies.py"),
    *("test_three_dimensions.py", "equations/test_turbulence.py", "experiment/test_comparison.py"),
    *("output/test_checkpoint.py", "output/test_report.py", "packing/test_averaging.py", "packing/test_cli.py"),
    *("packing/test_generator.py", "permeability/test_virtual.py", "scene/test_identity.py"),
    *("simulation/test_accuracy.py", "simulation/test_problem.py", "simulation/test_running.py"),
    *("files/test_stop_signals.py", "solvers/test_flow.py", "study/test_optimum.py", "study/test_running.py"),
    *("study/test_sensitivity.py", "study/test_uncertainty.py", "test_validation.py"),
}
"""Files whose tests run whole simulations or packings, or compile many forms: `make test-quick` leaves them out."""


def pytest_collection_modifyitems(items):
    """Mark what is slow."""
    here = Path(__file__).parent
    for item in items:
        if str(item.path.relative_to(here)) in SLOW:
            item.add_marker(pytest.mark.slow)
