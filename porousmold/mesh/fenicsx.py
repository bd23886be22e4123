"""Everything that differs between dolfinx 0.5.2 (Debian 12), 0.9 (Debian 13) and 0.11, behind one set of names.

No other file asks for a version or for `hasattr` of dolfinx, UFL or basix.
"""

import contextlib
import fcntl
import functools
import hashlib
import importlib
import importlib.machinery
import importlib.util
import inspect
import itertools
import logging
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import basix
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
from ..files.subprocesses import forked
from ..mpi import MPI
from .aliases import Communicator, Expression, Form, Mesh, Space

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
def _compiler_options() -> dict[str, Any]:
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


LOCK_INTERVAL = 0.05
"""Seconds between two looks at what another process compiles."""
_LOCKS: list[Any] = []
"""Open locks on what this process compiles: the system frees them when it ends, however it ends."""


def claim(module_name: str, cache: Path) -> None:
    """Return once a module stands in the cache, or once it is this process's to compile.

    FFCx takes an unfinished C file for the work of another process and waits for it, minutes if that was killed. Who compiles
    holds a lock on the file's name; who gets it finds the work of a process that is gone, and clears it away.
    """
    cache.mkdir(parents=True, exist_ok=True)
    begun, ready = (cache / f"{module_name}{ending}" for ending in (".c", ".c.cached"))
    if ready.exists():
        with contextlib.suppress(OSError):
            os.utime(ready)  # the date of its last use
        return
    lock = open(cache / f"{module_name}.lock", "w")  # noqa: SIM115
    while not ready.exists():
        with contextlib.suppress(BlockingIOError):
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if not ready.exists():
                begun.unlink(missing_ok=True)
            _LOCKS.append(lock)
            return
        time.sleep(LOCK_INTERVAL)
    lock.close()


def _compiled_module(name: str, cache: Path) -> Any:
    """A module that stands ready in the cache; None for one that does not.

    FFCx lists the whole folder for every form: 30 ms each where 14 000 forms are kept, three seconds of a run.
    """
    if not (cache / f"{name}.c.cached").exists():
        return None
    paths = (cache / f"{name}{suffix}" for suffix in importlib.machinery.EXTENSION_SUFFIXES)
    path = next((path for path in paths if path.exists()), None)
    spec = None if path is None else importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        return None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _claim_what_is_compiled() -> None:
    """Have FFCx `claim()` every module before it looks for it; one that looks elsewhere is left alone."""
    look_up: Any = getattr(ffcx.codegeneration.jit, "get_cached_module", None)
    if look_up is None:
        return

    def claimed(module_name: str, object_names: Any, cache_dir: Any, *others: Any, **options: Any) -> Any:
        claim(module_name, Path(cache_dir))
        module = _compiled_module(module_name, Path(cache_dir))
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


def mixed_space(domain: Mesh, elements: Sequence[Any]) -> Space:
    """Function space of the mixed element."""
    element = ufl.MixedElement(elements) if _basix_ufl is None else _basix_ufl.mixed_element(elements)
    return _space(domain, element)


def lagrange_space(domain: Mesh, degree: int = 1, components: int = 1) -> Space:
    """Continuous Lagrange space of the degree."""
    return _space(domain, lagrange_element(domain, degree, components))


def _space(domain: Mesh, element: Any) -> Space:
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


def vertex_rule(cell_type: str) -> dict[str, Any]:
    """Quadrature at a reference cell's vertices with equal weights, as metadata of a measure: (points, weights).

    `cell_type` is a name such as "quadrilateral". FFCx's own scheme "vertex" knows no quadrilaterals before 0.7.
    """
    cell = getattr(basix.CellType, cell_type)
    points = basix.geometry(cell)
    volume = float(np.sum(basix.make_quadrature(cell, 1)[1]))
    return {
        "quadrature_rule": "custom",
        "quadrature_degree": 1,
        "quadrature_points": tuple(map(tuple, points.tolist())),
        "quadrature_weights": (volume / len(points),) * len(points),
    }


def column_rule(flow_axis: int, degree: int) -> dict[str, Any]:
    """Quadrature on quadrilaterals at the ends of reference axis `flow_axis` and at Gauss points along the other."""
    gauss, weights = basix.make_quadrature(basix.CellType.interval, degree)
    points = []
    for end in (0.0, 1.0):
        for along in gauss[:, 0]:
            points.append((end, float(along)) if flow_axis == 0 else (float(along), end))
    return {
        "quadrature_rule": "custom",
        "quadrature_degree": degree,
        "quadrature_points": tuple(points),
        "quadrature_weights": tuple(float(0.5 * weight) for weight in weights) * 2,
    }


def flow_axis(domain: Mesh) -> int:
    """Reference axis (0 or 1) of a rectangle mesh's cells along x[0] (a collective call)."""
    nodes = cell_vertices(domain)
    mine = None
    if len(nodes):
        first, second = domain.geometry.x[nodes[0, :2], 0]
        mine = 0 if abs(second - first) > 0.0 else 1
    return next(axis for axis in domain.comm.allgather(mine) if axis is not None)


def evaluate(expression: Expression, domain: Mesh, points: Floats) -> Callable[[], Floats]:
    """Function that gives an expression's present values in all local cells at reference points: (cells, points x size)."""
    compiled = _expression_at(expression, domain, np.asarray(points))
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


def nodal_values(expression: Expression, space: Space) -> Floats:
    """The expression's values at the nodes of a scalar Lagrange space of degree 1; of a vector's entries, a row each."""
    shape = expression.ufl_shape
    target = lagrange_space(space.mesh, 1, *shape) if shape else space
    function = fem.Function(target)
    function.interpolate(compiled_expression(expression, target))
    values = function.x.array.copy()
    return values.reshape(-1, *shape).T if shape else values


class PointValues:
    """Values of expressions at the quadrature points of the cells, or in the cells' middles where no degree is given, as
    functions for forms: `add()` them all, then `compile()`; `renew()` evaluates them together, in a third of the time."""

    def __init__(self, domain: Mesh, quadrature_degree: int | None = None) -> None:
        self._domain, self._degree = domain, quadrature_degree
        self._entries: list[Any] = []
        self._parts: list[tuple[fem.Function, slice, Floats]] = []

    def add(self, expression: Expression) -> Any:
        """A function (of a tensor the tensor of its entries) that has the expression's values once they are renewed."""
        shape = expression.ufl_shape
        entries = [expression[index] if index else expression for index in np.ndindex(*shape)]
        count = len(entries)
        function = fem.Function(self._space(count))
        table = dof_table(function.function_space)
        places = count * table[:, :, None] + np.arange(count)
        self._parts.append((function, slice(len(self._entries), len(self._entries) + count), places))
        self._entries += entries
        if len(shape) < 2:
            return function
        return ufl.as_tensor(
            [[function[row * shape[1] + column] for column in range(shape[1])] for row in range(shape[0])]
        )

    def _space(self, components: int) -> Space:
        if self._degree is None:
            return cell_constant_space(self._domain, components)
        if _basix_ufl is None:
            cell, arguments = self._domain.ufl_cell(), {"degree": self._degree, "quad_scheme": "default"}
            if components == 1:
                return _space(self._domain, ufl.FiniteElement("Quadrature", cell, **arguments))
            return _space(self._domain, ufl.VectorElement("Quadrature", cell, dim=components, **arguments))
        shape = () if components == 1 else (components,)
        cell = self._domain.basix_cell()
        return _space(self._domain, _basix_ufl.quadrature_element(cell, value_shape=shape, degree=self._degree))

    def compile(self) -> None:
        """Compile what evaluates them all."""
        cell = getattr(basix.CellType, cell_name(self._domain))
        points = basix.make_quadrature(cell, self._degree or 1)[0]
        self._values = evaluate(ufl.as_vector(self._entries), self._domain, points)
        self._shape = -1, len(points), len(self._entries)

    def renew(self) -> None:
        """Evaluate the expressions in all local cells, ghosts included."""
        values = self._values().reshape(self._shape)
        for function, columns, places in self._parts:
            function.x.array[places] = values[:, :, columns]


def petsc_vector(function: fem.Function) -> Any:
    """The function's PETSc vector: a view, not a copy."""
    return function.x.petsc_vec if hasattr(function.x, "petsc_vec") else function.vector


class DeferredForm:
    """A UFL form that is compiled while others are: its compilation begins at once, in a process of its own, and is waited for
    where `form` is first asked for. Forms that were compiled before are only loaded then."""

    def __init__(self, form: Expression) -> None:
        self._ufl_form = form
        self._child = _begin_to_compile(form) if form.ufl_domain().ufl_cargo().comm.size == 1 else None
        _PENDING.append(self)

    @functools.cached_property
    def form(self) -> Form:
        """The compiled form (collective)."""
        if self._child is not None:
            with contextlib.suppress(ChildProcessError):
                os.waitpid(self._child, 0)
        compiled = compiled_form(self._ufl_form)
        if self._child is not None:
            _known(self._ufl_form).touch()
        return compiled


_PENDING: list[DeferredForm] = []
"""Forms begun since the last `finish_compiling`."""


def finish_compiling() -> None:
    """Wait for every form that was begun (collective)."""
    while _PENDING:
        _ = _PENDING.pop(0).form


def _known(form: Expression) -> Path:
    """File that is there if a form of this signature was compiled once."""
    signature = hashlib.sha256(f"{dolfinx.__version__} {form.signature()}".encode()).hexdigest()
    known = _compiler_options()["cache_dir"] / "known"
    known.mkdir(exist_ok=True)
    return Path(known / signature)


def _begin_to_compile(form: Expression) -> int | None:
    """Number of a process that compiles the form into the cache; None where it stands there."""
    if _known(form).exists():
        return None
    return forked(partial(compiled_form, form))


def compiled_form(form: Expression) -> Form:
    """The UFL form, compiled (cached on disk by FFCx)."""
    with _quiet_compiler():
        try:
            return fem.form(form, jit_options=_compiler_options())  # type: ignore[call-arg]
        except TypeError:  # dolfinx 0.5
            return fem.form(form, jit_params=_compiler_options())


def compiled_expression(expression: Expression, space: Space) -> Any:
    """The UFL expression, compiled for interpolation into the space."""
    points = space.element.interpolation_points
    return _expression_at(expression, space.mesh, points() if callable(points) else points)


def _expression_at(expression: Expression, domain: Mesh, points: Floats) -> Any:
    if expression.ufl_domain() is None:  # a number: dolfinx wants to know where it lives
        zeros = [fem.Constant(domain, 0.0)] * max(int(np.prod(expression.ufl_shape)), 1)
        expression += ufl.as_vector(zeros) if expression.ufl_shape else zeros[0]
    with _quiet_compiler():
        try:
            return fem.Expression(expression, points, jit_options=_compiler_options())  # type: ignore[call-arg]
        except TypeError:  # dolfinx 0.5
            return fem.Expression(expression, points, jit_params=_compiler_options())


def create_matrix(form: Expression) -> Any:
    """PETSc matrix with the form's sparsity."""
    return fem_petsc.create_matrix(form)


def assemble_matrix(matrix: PETSc.Mat, form: Expression, conditions: Sequence[Any]) -> None:
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


def array_length(space: Space) -> int:
    """Length of the local array of a function of a space, ghosts included."""
    return int((space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts) * space.dofmap.index_map_bs)


def leaves(space: Space) -> list[tuple[Space, Integers]]:
    """(space, numbers in the whole) of every scalar or vector part of a space."""
    if space.num_sub_spaces == 0 or space.dofmap.index_map_bs > 1:
        return [(space, np.arange(array_length(space)))]
    return [collapse(space, part) for part in range(space.num_sub_spaces)]


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


def mesh_of_gmsh(model: Any, communicator: Communicator, dimension: int) -> tuple[Any, ...]:
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


def facet_corners(domain: Mesh, facets: Integers) -> Floats:
    """Places (n, corners, 3) of the corners of local facets."""
    topology, dimension = domain.topology, domain.topology.dim
    topology.create_connectivity(dimension - 1, 0)
    topology.create_connectivity(dimension, 0)
    vertices = topology.connectivity(dimension, 0).array
    place_of = np.zeros((vertices.max() + 1 if vertices.size else 0, 3))
    place_of[vertices] = domain.geometry.x[cell_vertices(domain).ravel()]
    of_facet = topology.connectivity(dimension - 1, 0)
    corners = [of_facet.links(facet) for facet in facets]
    return place_of[np.array(corners)] if corners else np.zeros((0, dimension, 3))


def spans_along_flow(space: Space) -> Floats:
    """x[0] (n, 3) where what each node of a scalar space stands for begins, of the node, and where it ends: halfway to the far
    ends of its cells."""
    place, table = space.tabulate_dof_coordinates()[:, 0], dof_table(space)
    low, high = place.copy(), place.copy()
    ends = place[table]
    np.minimum.at(low, table, ends.min(axis=1)[:, None])
    np.maximum.at(high, table, ends.max(axis=1)[:, None])
    return np.column_stack((0.5 * (place + low), place, 0.5 * (place + high)))


def dof_table(space: Space) -> Integers:
    """Unknowns of the local cells of a scalar space as an array, one row a cell."""
    table = space.dofmap.list
    if hasattr(table, "array"):
        return table.array.reshape(table.num_nodes, -1)
    return np.asarray(table)


def write_mesh(file: Any, domain: Mesh) -> None:
    """Write the mesh into an open XDMF file."""
    file.write_mesh(domain)
