"""The one module that knows dolfinx's versions."""

import importlib.machinery
import subprocess
import sys
import threading
import time
import uuid

import dolfinx.mesh
import numpy as np
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI

from porousmold.mesh import fenicsx, ranks


def test_a_killed_compilation_is_forgotten_but_not_that_of_a_living_process(tmp_path):
    begun, ready = tmp_path / "one.c", tmp_path / "one.c.cached"
    begun.touch()
    fenicsx.claim("one", tmp_path)  # nobody holds the lock of what was begun
    assert not begun.exists()
    begun.touch()  # this process is the one that compiles
    waiting = threading.Thread(target=fenicsx.claim, args=("one", tmp_path))
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
from porousmold.mesh import fenicsx, ranks
cache = Path(sys.argv[1])
fenicsx.claim("two", cache)
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
    fenicsx.claim("two", tmp_path)
    assert not (tmp_path / "two.c").exists()


def test_compiling_leaves_the_hash_of_a_mesh_alone():
    """Else FFCx 0.5 does not find its own tables for coordinates that were hashed before."""
    domain = fenicsx.box_mesh(MPI.COMM_SELF, (1, 1))
    before = hash(domain.ufl_domain())
    fenicsx.compiled_form(uuid.uuid4().int % 10**12 * 1e-12 * ufl.SpatialCoordinate(domain)[0] * ufl.dx)  # a new one
    assert hash(domain.ufl_domain()) == before


def test_compiled_forms_leave_denormal_numbers_alone():
    """A library that is linked with unsafe mathematics would flush them to zero in the whole process."""
    domain = fenicsx.box_mesh(MPI.COMM_SELF, (1, 1))
    fenicsx.compiled_form(ufl.sqrt(ufl.SpatialCoordinate(domain)[0]) * ufl.dx)
    assert (np.array([1e-300]) * 1e-15)[0] > 0.0


def test_nodal_values_of_a_vector_are_those_of_its_entries():
    domain = fenicsx.box_mesh(MPI.COMM_SELF, (3, 2))
    space, (x, y) = fenicsx.lagrange_space(domain), ufl.SpatialCoordinate(domain)
    together = fenicsx.nodal_values(ufl.as_vector([x + y, 3.0 * y]), space)
    assert np.array_equal(together, [fenicsx.nodal_values(x + y, space), fenicsx.nodal_values(3.0 * y, space)])


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


SIGNATURES = """
import dolfinx.mesh
import ufl
from dolfinx import fem
from mpi4py import MPI
from porousmold.mesh import fenicsx
domain = dolfinx.mesh.create_unit_square(MPI.COMM_SELF, 1, 1)
found = set()
for _ in range(60):
    first, second, third = (fem.Constant(domain, 1.0) for _ in range(3))
    found.add((first * second * third * ufl.dx(domain)).signature())
print(len(found))
"""


def test_a_form_is_the_same_one_whatever_the_numbers_of_its_constants():
    """UFL orders constants by their text, 100 before 99: every study compiled some forms anew when theirs got a digit more."""
    done = subprocess.run([sys.executable, "-c", SIGNATURES], capture_output=True, text=True, timeout=120)
    assert done.stdout.split()[-1] == "1", done.stderr
