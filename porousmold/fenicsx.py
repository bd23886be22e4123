"""Everything that differs between dolfinx 0.5.2 (Debian 12), 0.9 (Debian 13) and 0.11, behind one set of names.

No other file asks for a version or for `hasattr` of dolfinx, UFL or basix.
"""

import logging

import dolfinx
import numpy as np
import ufl
from dolfinx import fem, io, mesh
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

dolfinx_version = dolfinx.__version__

try:
    import basix.ufl as _basix_ufl
except ImportError:  # dolfinx 0.5: elements come from UFL itself
    _basix_ufl = None

# FFCx and its C compiler report every step at INFO, which would stand in front of the run's own lines.
for _name in ("root", "FFCx", "UFL"):
    logging.getLogger(_name).setLevel(logging.WARNING)

_COMPILER_OPTIONS = {"cffi_extra_compile_args": ["-O2"]}


def lagrange_element(domain, degree, components=1):
    """Continuous Lagrange element on the mesh's cells, scalar or with a number of components."""
    if _basix_ufl is None:
        if components == 1:
            return ufl.FiniteElement("Lagrange", domain.ufl_cell(), degree)
        return ufl.VectorElement("Lagrange", domain.ufl_cell(), degree, dim=components)
    shape = None if components == 1 else (components,)
    return _basix_ufl.element("Lagrange", domain.basix_cell(), degree, shape=shape)


def mixed_space(domain, elements):
    """Function space of the mixed element."""
    element = ufl.MixedElement(elements) if _basix_ufl is None else _basix_ufl.mixed_element(elements)
    return _space(domain, element)


def lagrange_space(domain, degree=1, components=1):
    """Continuous Lagrange space of the degree."""
    return _space(domain, lagrange_element(domain, degree, components))


def _space(domain, element):
    return fem.functionspace(domain, element) if hasattr(fem, "functionspace") else fem.FunctionSpace(domain, element)


def cell_constant_space(domain):
    """Discontinuous space of one value per cell."""
    if _basix_ufl is None:
        return _space(domain, ufl.FiniteElement("DG", domain.ufl_cell(), 0))
    return _space(domain, _basix_ufl.element("DG", domain.basix_cell(), 0))


def petsc_vector(function):
    """The function's PETSc vector: a view, not a copy."""
    return function.x.petsc_vec if hasattr(function.x, "petsc_vec") else function.vector


def compiled_form(form):
    """The UFL form, compiled (cached on disk by FFCx)."""
    try:
        return fem.form(form, jit_options=_COMPILER_OPTIONS)
    except TypeError:  # dolfinx 0.5
        return fem.form(form, jit_params=_COMPILER_OPTIONS)


def compiled_expression(expression, space):
    """The UFL expression, compiled for interpolation into the space."""
    points = space.element.interpolation_points
    points = points() if callable(points) else points
    try:
        return fem.Expression(expression, points, jit_options=_COMPILER_OPTIONS)
    except TypeError:  # dolfinx 0.5
        return fem.Expression(expression, points, jit_params=_COMPILER_OPTIONS)


def create_matrix(form):
    """PETSc matrix with the form's sparsity."""
    return fem_petsc.create_matrix(form)


def assemble_matrix(matrix, form, conditions):
    """Fill the matrix with the form, 1 on the diagonal of the conditions' unknowns, and finish the assembly."""
    matrix.zeroEntries()
    fem_petsc.assemble_matrix(matrix, form, conditions)
    matrix.assemble()


def assemble_vector(vector, form):
    """Fill the vector with the linear form, contributions of all ranks added."""
    with vector.localForm() as local:
        local.set(0.0)
    fem_petsc.assemble_vector(vector, form)
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)


def constrained_unknowns(condition):
    """Local numbers (unrolled, ghosts included) of the unknowns that a Dirichlet condition holds."""
    numbers = condition.dof_indices()[0]
    return np.asarray(numbers, dtype=np.int64)


def collapse(space, index):
    """Collapsed subspace and the map from its unknowns to those of the mixed space (a collective call)."""
    subspace, numbers = space.sub(index).collapse()
    return subspace, np.asarray(numbers, dtype=np.int64)


def rectangle_mesh(communicator, cells):
    """Unit square of cells[0] x cells[1] quadrilaterals with ghost cells shared across facets."""
    domain = mesh.create_rectangle(
        communicator,
        [np.zeros(2), np.ones(2)],
        list(cells),
        mesh.CellType.quadrilateral,
        ghost_mode=mesh.GhostMode.shared_facet,
    )
    create_connectivities(domain)
    return domain


def create_connectivities(domain):
    """Cell-cell and facet-cell connectivities, which locating and tagging entities need."""
    dimension = domain.topology.dim
    domain.topology.create_connectivity(dimension, dimension)
    domain.topology.create_connectivity(dimension - 1, dimension)


def read_gmsh(path, communicator):
    """Mesh, cell tags and facet tags of a gmsh file with 2-D cells; `OSError` if gmsh cannot read it."""
    import gmsh

    if communicator.rank == 0:
        gmsh.initialize()
        gmsh.option.setNumber("General.Terminal", 0)
        try:
            gmsh.open(str(path))
            if gmsh.model.mesh.getNodes()[0].size == 0:
                gmsh.model.mesh.generate(2)
        except Exception as error:
            gmsh.finalize()
            raise OSError(str(error)) from error
    reader = io.gmshio if hasattr(io, "gmshio") else __import__("dolfinx.io.gmsh", fromlist=["gmsh"])
    result = reader.model_to_mesh(gmsh.model, communicator, 0, gdim=2)
    if communicator.rank == 0:
        gmsh.finalize()
    if isinstance(result, tuple):
        domain, cell_tags, facet_tags = result[:3]
    else:  # dolfinx 0.10 on: a named tuple of more
        domain, cell_tags, facet_tags = result.mesh, result.cell_tags, result.facet_tags
    create_connectivities(domain)
    return domain, cell_tags, facet_tags


def cell_vertices(domain):
    """Geometry nodes of the local cells (owned and ghosts) as an array, one row a cell, in tensor order for quads."""
    nodes = domain.geometry.dofmap
    if hasattr(nodes, "array"):  # dolfinx 0.5: an adjacency list
        return nodes.array.reshape(nodes.num_nodes, -1)
    return np.asarray(nodes)


def dof_table(space):
    """Unknowns of the local cells of a scalar space as an array, one row a cell."""
    table = space.dofmap.list
    if hasattr(table, "array"):
        return table.array.reshape(table.num_nodes, -1)
    return np.asarray(table)


def write_mesh(file, domain):
    """Write the mesh into an open XDMF file."""
    file.write_mesh(domain)


def containing_cells(domain, points):
    """For each point (rows of three coordinates) a local cell that contains it, or -1 where none of this rank does."""
    from dolfinx import geometry

    dimension = domain.topology.dim
    if hasattr(geometry, "bb_tree"):
        tree = geometry.bb_tree(domain, dimension)
        candidates = geometry.compute_collisions_points(tree, points)
    else:  # dolfinx 0.5
        tree = geometry.BoundingBoxTree(domain, dimension)
        candidates = geometry.compute_collisions(tree, points)
    colliding = geometry.compute_colliding_cells(domain, candidates, points)
    return np.array([colliding.links(i)[0] if len(colliding.links(i)) else -1 for i in range(len(points))])
