"""The one module that knows dolfinx's versions."""

import uuid

import numpy as np
import ufl
from mpi4py import MPI

from porousmold.mesh import fenicsx


def test_a_killed_compilation_is_forgotten_but_not_that_of_a_living_process(tmp_path):
    alone, shared = tmp_path / "alone", tmp_path / "shared"
    for cache in (alone, shared):
        cache.mkdir()
        for name in ("begun.c", "ready.c", "ready.c.cached"):
            (cache / name).touch()
    other_process = fenicsx.lock_cache.__wrapped__(shared)
    (shared / "begun.c").touch()
    locks = [fenicsx.lock_cache(cache) for cache in (alone, shared)]
    assert not (alone / "begun.c").exists()
    assert (alone / "ready.c").exists()
    assert (shared / "begun.c").exists()
    for lock in (other_process, *locks):
        lock.close()


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
