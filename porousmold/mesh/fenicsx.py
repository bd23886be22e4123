"""Everything that differs between dolfinx 0.5.2 (Debian 12), 0.9 (Debian 13) and 0.11, behind one set of names.

No other file asks for a version or for `hasattr` of dolfinx, UFL or basix.
"""

import contextlib
import functools
import hashlib
import importlib
import importlib.machinery
import importlib.util
import inspect
import itertools
import logging
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import dolfinx
import ffcx.codegeneration.jit
import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from ..arrays import Floats, Integers
from ..errors import InputError
from ..files.cache_folder import replacing_cache
from ..mpi import MPI
from .aliases import Communicator, Expression, Form, GmshModel, Mesh, Space
from .compiled_cache import claim, compiled_module

if threading.current_thread() is threading.main_thread():
    # PETSc takes the signal of a pipe that was closed, as by `| head`, for a crash; Python raises BrokenPipeError
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)

# UFL orders the constants of a sum or a product by their text, where 100 comes before 99: forms would be other ones, to be
# compiled anew, whenever the numbers of their constants get a digit more. With so many digits they never do
if hasattr(ufl.Constant, "_globalcount"):
    ufl.Constant._globalcount = 10**9
else:
    ufl.Constant._counter = itertools.count(10**9)

try:
    import basix.ufl as _basix_ufl
except ImportError:  # dolfinx 0.5: elements come from UFL itself
    _basix_ufl = None


@functools.cache
def compiler_options() -> dict[str, Any]:
    """Options of FFCx's compiler, with a cache of our own."""
    defaults = dolfinx.jit.get_options if hasattr(dolfinx.jit, "get_options") else dolfinx.jit.get_parameters
    cache = Path(defaults()["cache_dir"]) / "porousmold"
    try:
        cache.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        allowed = f"must be a folder where compiled forms can be kept: {error.strerror}"
        raise InputError("XDG_CACHE_HOME", str(cache), allowed) from error
    if (other := replacing_cache()) is not None and MPI.COMM_WORLD.rank == 0:
        message = "the user's cache cannot be written: compiled forms are kept in %s (or where XDG_CACHE_HOME says)"
        logging.getLogger(__name__).warning(message, other)
    # unsafe mathematics turns powers into roots and products: half the time of a residual, the same to rounding. Given to the
    # compiler alone, not to the linker, it leaves denormal numbers as they are in all other code
    flags = ["-O2", "-funsafe-math-optimizations", "-fno-math-errno"]
    return {"cffi_extra_compile_args": flags, "cache_dir": cache, "timeout": 300}


def _claim_what_is_compiled() -> None:
    """Have FFCx `claim()` every module before it looks for it; one that looks elsewhere is left alone."""
    look_up: Any = getattr(ffcx.codegeneration.jit, "get_cached_module", None)
    if look_up is None:
        return

    def claimed(module_name: str, object_names: Any, cache_dir: Any, *others: Any, **options: object) -> Any:
        claim(module_name, Path(cache_dir))
        module = compiled_module(module_name, Path(cache_dir))
        if module is not None:
            return [getattr(module.lib, name) for name in object_names], module
        return look_up(module_name, object_names, cache_dir, *others, **options)

    ffcx.codegeneration.jit.get_cached_module = claimed


_claim_what_is_compiled()


@contextlib.contextmanager
def _quiet_compiler() -> Iterator[Any]:
    """FFCx and its C compiler report every step at INFO, which would stand amid the run's own lines."""
    before = logging.root.manager.disable
    logging.disable(logging.INFO)
    try:
        yield
    finally:
        logging.disable(before)


def lagrange_element(domain: Mesh, degree: int, components: int = 1) -> Any:
    """Continuous Lagrange element on the mesh's cells, scalar or with a number of components."""
    if _basix_ufl is None:
        if components == 1:
            return ufl.FiniteElement("Lagrange", domain.ufl_cell(), degree)
        return ufl.VectorElement("Lagrange", domain.ufl_cell(), degree, dim=components)
    shape = None if components == 1 else (components,)
    return _basix_ufl.element("Lagrange", domain.basix_cell(), degree, shape=shape)


def mixed_space(domain: Mesh, elements: Sequence[object]) -> Space:
    """Function space of the mixed element."""
    element = ufl.MixedElement(elements) if _basix_ufl is None else _basix_ufl.mixed_element(elements)
    return _space(domain, element)


def lagrange_space(domain: Mesh, degree: int = 1, components: int = 1) -> Space:
    """Continuous Lagrange space of the degree."""
    return _space(domain, lagrange_element(domain, degree, components))


def _space(domain: Mesh, element: object) -> Space:
    with _quiet_compiler():
        if hasattr(fem, "functionspace"):
            return fem.functionspace(domain, element)
        return fem.FunctionSpace(domain, element)


def cell_constant_space(domain: Mesh, components: int = 1) -> Space:
    """Discontinuous space of one value per cell, scalar or with a number of components."""
    if _basix_ufl is None:
        if components == 1:
            return _space(domain, ufl.FiniteElement("DG", domain.ufl_cell(), 0))
        return _space(domain, ufl.VectorElement("DG", domain.ufl_cell(), 0, dim=components))
    return _space(
        domain, _basix_ufl.element("DG", domain.basix_cell(), 0, shape=None if components == 1 else (components,))
    )


def quadrature_space(domain: Mesh, degree: int, components: int = 1) -> Space:
    """Space of values at the points of a quadrature rule, scalar or with a number of components."""
    if _basix_ufl is None:
        cell, arguments = domain.ufl_cell(), {"degree": degree, "quad_scheme": "default"}
        if components == 1:
            return _space(domain, ufl.FiniteElement("Quadrature", cell, **arguments))
        return _space(domain, ufl.VectorElement("Quadrature", cell, dim=components, **arguments))
    shape = () if components == 1 else (components,)
    return _space(domain, _basix_ufl.quadrature_element(domain.basix_cell(), value_shape=shape, degree=degree))


def evaluate(expression: Expression, domain: Mesh, points: Floats) -> Callable[[], Floats]:
    """Function that gives an expression's present values in all local cells at reference points: (cells, points x size)."""
    compiled = expression_at(expression, domain, np.asarray(points))
    cells_map = domain.topology.index_map(domain.topology.dim)
    cells = np.arange(cells_map.size_local + cells_map.num_ghosts, dtype=np.int32)

    def values() -> Floats:
        try:
            result = compiled.eval(domain, cells)
        except TypeError:  # dolfinx 0.5
            result = compiled.eval(cells)
        return np.asarray(result).reshape(len(cells), len(points) * int(np.prod(expression.ufl_shape)))

    return values


def cell_name(domain: Mesh) -> str:
    """Name of the mesh's cells, such as "quadrilateral"."""
    name = domain.ufl_cell().cellname
    return str(name() if callable(name) else name)  # of dolfinx 0.11 on a property


def petsc_vector(function: fem.Function) -> Any:
    """The function's PETSc vector: a view, not a copy."""
    return function.x.petsc_vec if hasattr(function.x, "petsc_vec") else function.vector


def signature_of(form: Expression) -> str:
    """What a UFL form and this dolfinx have in common with no other."""
    return hashlib.sha256(f"{dolfinx.__version__} {form.signature()}".encode()).hexdigest()


def compiled_form(form: Expression) -> Form:
    """The UFL form, compiled (cached on disk by FFCx)."""
    with _quiet_compiler():
        try:
            return fem.form(form, jit_options=compiler_options())  # type: ignore[call-arg]
        except TypeError:  # dolfinx 0.5
            return fem.form(form, jit_params=compiler_options())


def compiled_expression(expression: Expression, space: Space) -> Any:
    """The UFL expression, compiled for interpolation into the space."""
    points = space.element.interpolation_points
    return expression_at(expression, space.mesh, points() if callable(points) else points)


def expression_at(expression: Expression, domain: Mesh, points: Floats) -> Any:
    if expression.ufl_domain() is None:  # a number: dolfinx wants to know where it lives
        zeros = [fem.Constant(domain, 0.0)] * max(int(np.prod(expression.ufl_shape)), 1)
        expression += ufl.as_vector(zeros) if expression.ufl_shape else zeros[0]
    with _quiet_compiler():
        try:
            return fem.Expression(expression, points, jit_options=compiler_options())  # type: ignore[call-arg]
        except TypeError:  # dolfinx 0.5
            return fem.Expression(expression, points, jit_params=compiler_options())


def create_matrix(form: Expression) -> Any:
    """PETSc matrix with the form's sparsity."""
    return fem_petsc.create_matrix(form)


def assemble_matrix(matrix: PETSc.Mat, form: Expression, conditions: Sequence[object]) -> None:
    """Fill the matrix with the form, 1 on the diagonal of the conditions' unknowns, and finish the assembly."""
    matrix.zeroEntries()
    fem_petsc.assemble_matrix(matrix, form, conditions)  # type: ignore[arg-type]
    matrix.assemble()


def assemble_vector(vector: PETSc.Vec, form: Expression) -> None:
    """Fill the vector with the linear form, contributions of all ranks added."""
    with vector.localForm() as local:
        local.set(0.0)
    fem_petsc.assemble_vector(vector, form)
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)


def collapse(space: Space, index: int) -> tuple[Space, Integers]:
    """Collapsed subspace and the map from its unknowns to those of the mixed space (a collective call)."""
    subspace, numbers = space.sub(index).collapse()
    return subspace, np.asarray(numbers, dtype=np.int64).ravel()  # dolfinx 0.11 gives a list of such maps


def box_mesh(communicator: Communicator, cells: Sequence[int]) -> Mesh:
    """Unit square or cube of cells[0] x cells[1] (x cells[2]) cells with ghost cells shared across facets."""
    flat = len(cells) == 2
    create: Any = mesh.create_rectangle if flat else mesh.create_box
    kind = mesh.CellType.quadrilateral if flat else mesh.CellType.hexahedron
    corners = [np.zeros(len(cells)), np.ones(len(cells))]
    domain = create(communicator, corners, list(cells), kind, ghost_mode=mesh.GhostMode.shared_facet)
    _complete(domain)
    return domain


def _complete(domain: Mesh) -> None:
    """Cell-cell and facet-cell connectivities, which locating and tagging entities need; a coordinate element that stays."""
    dimension = domain.topology.dim
    domain.topology.create_connectivity(dimension, dimension)
    domain.topology.create_connectivity(dimension - 1, dimension)
    if _basix_ufl is None:
        # FFCx 0.5 changes it to this at its first compilation, and what was hashed before is not found again
        element = domain.ufl_domain().ufl_coordinate_element()
        nodal = ufl.FiniteElement(element.family(), element.cell(), element.degree(), variant="equispaced")
        domain.ufl_domain()._ufl_coordinate_element = ufl.VectorElement(nodal)


def mesh_of_gmsh(model: GmshModel, communicator: Communicator, dimension: int) -> tuple[Any, ...]:
    """Mesh, cell tags and facet tags of the model that rank 0 holds (a collective call)."""
    try:
        reader = importlib.import_module("dolfinx.io.gmshio")
    except ImportError:  # dolfinx 0.10 on
        reader = importlib.import_module("dolfinx.io.gmsh")
    # interior facets between bed and wall need the cells on both sides; dolfinx 0.5 has them without being asked
    sharing = {}
    if "partitioner" in inspect.signature(reader.model_to_mesh).parameters and hasattr(mesh, "create_cell_partitioner"):
        try:
            sharing["partitioner"] = mesh.create_cell_partitioner(mesh.GhostMode.shared_facet)
        except TypeError:  # dolfinx 0.11 on asks how many cells a facet may have
            sharing["partitioner"] = mesh.create_cell_partitioner(mesh.GhostMode.shared_facet, 2)
    domain, cell_tags, facet_tags = tuple(reader.model_to_mesh(model, communicator, 0, gdim=dimension, **sharing))[:3]
    _complete(domain)
    return domain, cell_tags, facet_tags


def cell_vertices(domain: Mesh) -> Integers:
    """Geometry nodes of the local cells (owned and ghosts) as an array, one row a cell, in tensor order for quads."""
    nodes = domain.geometry.dofmap
    if hasattr(nodes, "array"):  # dolfinx 0.5: an adjacency list
        return nodes.array.reshape(nodes.num_nodes, -1)
    return np.asarray(nodes)


def dof_table(space: Space) -> Integers:
    """Unknowns of the local cells of a scalar space as an array, one row a cell."""
    table = space.dofmap.list
    if hasattr(table, "array"):
        return table.array.reshape(table.num_nodes, -1)
    return np.asarray(table)


def write_mesh(file: Any, domain: Mesh) -> None:
    """Write the mesh into an open XDMF file."""
    file.write_mesh(domain)
