"""Settings of all tests, and which of them are slow: those that were measured to be."""

import json
import time
from pathlib import Path

import pytest
from hypothesis import settings
from mpi4py import MPI  # noqa: F401 - first, so that studies in tests fork no workers (`porousmold.mpi.IS_ALONE`)

# a busy machine is no failure; pytest's own time-out guards against what never ends
settings.register_profile("same-examples", deadline=None, derandomize=True)
settings.register_profile("new-examples", deadline=None, max_examples=1000)  # `make fuzz-test` searches with these
settings.load_profile("same-examples")

DURATIONS = Path(__file__).parent / "durations.json"
"""Seconds of the tests that take longest, by `make test-durations`: `make test-quick` leaves those above `SLOW` out, `make test`
those above `HEAVY`, which `make test-heavy` runs."""
SLOW, HEAVY = 0.3, 3.0
"""s of a test and of the fixtures that it needs, also of those that another test has made for it."""
_of_fixtures: dict[tuple[str, str], float] = {}


def pytest_addoption(parser):
    """--store-durations."""
    parser.addoption("--store-durations", action="store_true", help=f"write {DURATIONS.name} from what this run takes")


def pytest_collection_modifyitems(items):
    """Mark what is slow, and what is heavy."""
    known = json.loads(DURATIONS.read_text(encoding="utf-8"))
    for item in items:
        for mark, limit in ((pytest.mark.slow, SLOW), (pytest.mark.heavy, HEAVY)):
            if known.get(item.nodeid, 0.0) > limit:
                item.add_marker(mark)


@pytest.hookimpl(hookwrapper=True)
def pytest_fixture_setup(fixturedef):
    """Note how long a fixture takes; those of a module are made once, for the first test that needs them."""
    start = time.perf_counter()
    yield
    _of_fixtures[fixturedef.baseid, fixturedef.argname] = time.perf_counter() - start


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    """Tell the process that collects the reports how long the fixtures took."""
    if call.when == "setup":
        definitions = item._fixtureinfo.name2fixturedefs.values()
        keys = [(one[-1].baseid, one[-1].argname) for one in definitions]
        item.user_properties.append(("fixtures", sum(_of_fixtures.get(key, 0.0) for key in keys)))
    yield


def pytest_configure(config):
    """Collect durations where asked, in the process that has all reports."""
    if config.getoption("--store-durations") and not hasattr(config, "workerinput"):
        config.pluginmanager.register(_Durations())


class _Durations:
    """Seconds of all tests, written at the end."""

    def __init__(self):
        self._seconds = {}

    def pytest_runtest_logreport(self, report):
        """Add what a part of a test took."""
        if report.when == "call":
            self._seconds[report.nodeid] = report.duration + dict(report.user_properties)["fixtures"]

    def pytest_sessionfinish(self):
        """Keep those above the limit; of tests that did not run, what was known."""
        known = json.loads(DURATIONS.read_text(encoding="utf-8"))
        kept = {name: round(value, 1) for name, value in (known | self._seconds).items() if value > SLOW}
        DURATIONS.write_text(json.dumps(kept, indent=0, sort_keys=True) + "\n", encoding="utf-8")
