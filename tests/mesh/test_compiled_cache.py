"""Who compiles a form where processes are killed, and how a compiled one is found."""

import importlib.machinery
import subprocess
import sys
import threading
import time

import dolfinx.mesh
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI

from porousmold.mesh import fenicsx, ranks
from porousmold.mesh.compiled_cache import claim


def test_a_killed_compilation_is_forgotten_but_not_that_of_a_living_process(tmp_path):
    begun, ready = tmp_path / "one.c", tmp_path / "one.c.cached"
    begun.touch()
    claim("one", tmp_path)  # nobody holds the lock of what was begun
    assert not begun.exists()
    begun.touch()  # this process is the one that compiles
    waiting = threading.Thread(target=claim, args=("one", tmp_path))
    waiting.start()
    waiting.join(0.5)
    assert waiting.is_alive()
    assert begun.exists()
    ready.touch()
    waiting.join(30.0)
    assert not waiting.is_alive()
    assert begun.exists()


def test_what_a_killed_process_began_is_compiled_anew_though_another_one_lives(tmp_path):
    """FFCx alone waits for the file of the killed one until its time is out."""
    begin = """
import sys, time
from pathlib import Path
from porousmold.mesh.compiled_cache import claim
cache = Path(sys.argv[1])
claim("two", cache)
(cache / "two.c").touch()
time.sleep(60)
"""
    killed = subprocess.Popen([sys.executable, "-c", begin, str(tmp_path)])
    end = time.monotonic() + 50.0
    while not (tmp_path / "two.c").exists() and time.monotonic() < end:
        time.sleep(0.1)
    assert (tmp_path / "two.c").exists()
    killed.kill()
    killed.wait()
    claim("two", tmp_path)
    assert not (tmp_path / "two.c").exists()


def test_a_form_that_is_compiled_is_found_without_a_look_at_the_whole_cache(monkeypatch):
    """However many forms are kept: listing 14 000 of them for each form took three seconds of a run."""
    domain = dolfinx.mesh.create_unit_square(MPI.COMM_SELF, 2, 2)

    form = fem.Constant(domain, 3.0) * ufl.dx(domain)

    def area():
        return ranks.integral(MPI.COMM_SELF, fenicsx.compiled_form(form))

    assert area() == pytest.approx(3.0)
    listed = []
    original = importlib.machinery.FileFinder._fill_cache

    def noted(finder):
        listed.append(finder.path)
        original(finder)

    monkeypatch.setattr(importlib.machinery.FileFinder, "_fill_cache", noted)
    assert area() == pytest.approx(3.0)
    assert not [path for path in listed if "fenics" in path], listed
