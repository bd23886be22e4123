"""The one module that knows dolfinx's versions."""

import subprocess
import sys
import uuid

import numpy as np
import ufl
from mpi4py import MPI

from porousmold.mesh import fenicsx


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
