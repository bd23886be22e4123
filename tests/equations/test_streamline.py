"""What the stabilisation of one cell does: what it lumps, what it conserves, what it keeps monotone."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from porousmold.equations.coordinates import Coordinates
from porousmold.equations.streamline import Carried, LumpedAtVertices, Streamline
from porousmold.mesh import fenicsx

from ..support import box, integral

LENGTH, WIDTH = 0.3, 0.02


def cell(*, advection=(5.0, 0.0), conduction=0.0, exchange=40.0, monotone=1.0, straight=True, melts=False):
    """One cell of a planar bed with its `Streamline`: (domain, dx, streamline)."""
    domain = box((1, 1), length=LENGTH, width=WIDTH)

    def number(value):
        return fem.Constant(domain.mesh, value)

    streamline = Streamline.of(
        Coordinates(domain.mesh, False),
        Carried(ufl.as_vector([number(value) for value in advection]), number(conduction), number(exchange)),
        number(0.0),
        number(monotone),
        straight,
        melts=melts,
    )
    return domain, domain.cell_measure(4), streamline


def itself(value):
    """What is stored where the capacity is 1."""
    return value


def molten(value):
    """Enthalpy of what melts from 2 to 2.4: one that bends within a cell."""
    return value + 20.0 * ufl.max_value(0.0, ufl.min_value(value - 2.0, 0.4))


def linear(domain, values):
    """The linear function with the values at the inlet's and at the outlet's nodes."""
    function = fem.Function(fenicsx.lagrange_space(domain.mesh))
    x = function.function_space.tabulate_dof_coordinates()[:, 0] / LENGTH
    function.x.array[:] = values[0] + (values[1] - values[0]) * x
    return function


def test_reach_is_half_a_cell_along_the_flow():
    domain, dx, streamline = cell(monotone=0.0)
    function = linear(domain, (1.0, 4.0))
    assert integral(streamline.upwinded.along(function) * dx) / (LENGTH * WIDTH) == pytest.approx(1.5)


def test_storage_of_a_monotone_cell_is_lumped_along_the_flow():
    """The integral of a product is that of the values at the nodes, the trapezoidal rule."""
    domain, dx, streamline = cell()
    (a, b), (c, d) = (1.0, 4.0), (2.0, -3.0)
    value, test = linear(domain, (a, b)), linear(domain, (c, d))
    found = integral(streamline.stored(itself, value, test) * dx)
    assert found == pytest.approx(LENGTH * WIDTH * (a * c + b * d) / 2.0)


def test_a_cell_that_becomes_monotone_keeps_its_heat():
    """However its enthalpy bends between its nodes."""
    heats = []
    for monotone in (0.0, 1.0):
        domain, dx, streamline = cell(monotone=monotone, melts=True)
        value, one = linear(domain, (1.0, 4.0)), linear(domain, (1.0, 1.0))
        heats.append(integral(streamline.stored(molten, value, one) * dx) / (LENGTH * WIDTH))
    assert heats == pytest.approx([(1.0 + 12.0) / 2.0] * 2)


def test_storage_of_other_cells_is_not_lumped():
    domain, dx, streamline = cell(monotone=0.0)
    value, test = linear(domain, (1.0, 4.0)), linear(domain, (2.0, -3.0))
    lumped = integral(streamline.stored(itself, value, test) * dx)
    assert lumped == pytest.approx(integral(value * test * dx))


@pytest.mark.parametrize("monotone", [0.0, 1.0])
@pytest.mark.parametrize("exchange", [0.1, 40.0, 1e5])
def test_exchange_takes_from_the_fluid_what_the_beads_get(monotone, exchange):
    """For a uniform test the two forms are the same, whatever the Stanton number."""
    domain, dx, streamline = cell(monotone=monotone, exchange=exchange)
    coefficient, value = fem.Constant(domain.mesh, exchange), linear(domain, (20.0, 7.0))
    one = linear(domain, (1.0, 1.0))
    beads = integral(streamline.exchanged(coefficient, value, one) * dx)
    fluid = integral(streamline.exchanged_downstream(coefficient, value, one) * dx)
    assert fluid == pytest.approx(beads, rel=1e-12)


@pytest.mark.parametrize("monotone", [0.0, 1.0])
def test_tests_of_the_carried_heat_add_up_to_one(monotone):
    """So that nothing is made or lost in a cell: the heat that a rise of 1 K along it takes from the flow."""
    domain, dx, streamline = cell(monotone=monotone)
    parts, rising = [linear(domain, values) for values in ((1.0, 0.0), (0.0, 1.0))], linear(domain, (0.0, 1.0))
    advection = ufl.as_vector([fem.Constant(domain.mesh, 5.0), fem.Constant(domain.mesh, 0.0)])
    carried = sum(integral(streamline.carried(advection, rising, part) * dx) for part in parts)
    assert carried == pytest.approx(5.0 * WIDTH)


def outlet_value(exchange, monotone, inlet, beads):
    """Fluid's value at the outlet of one cell between an inlet's value and beads of one value: the outlet's own equation."""
    domain, dx, streamline = cell(exchange=exchange, monotone=monotone)
    speed, coefficient = fem.Constant(domain.mesh, 5.0), fem.Constant(domain.mesh, exchange)
    test = linear(domain, (0.0, 1.0))

    def residual(outlet):
        value = linear(domain, (inlet, outlet))
        form = streamline.carried(ufl.as_vector([speed, 0.0]), value, test)
        form += streamline.exchanged_downstream(coefficient, value - fem.Constant(domain.mesh, beads), test)
        return integral(form * dx)

    start, slope = residual(0.0), residual(1.0) - residual(0.0)
    return -start / slope


@pytest.mark.parametrize("exchange", [0.01, 1.0, 30.0, 1e3, 1e6])
def test_outlet_of_a_monotone_cell_lies_between_inlet_and_beads(exchange):
    """An average of the upstream node and the beads at any Stanton number; without exchange it is the upstream node."""
    found = outlet_value(exchange, 1.0, 90.0, 20.0)
    assert 20.0 - 1e-9 <= found <= 90.0 + 1e-9
    if exchange <= 0.01:
        assert found == pytest.approx(90.0, abs=0.1)
    if exchange >= 1e6:
        assert found == pytest.approx(20.0, abs=0.1)


def simplices(dimension, *, conduction=0.0, exchange=40.0, monotone=1.0, seed=0, melts=False):
    """Two triangles or six tetrahedra of any shape, with a flow in any direction: (mesh, advection, streamline)."""
    kind = {2: mesh.CellType.triangle, 3: mesh.CellType.tetrahedron}[dimension]
    create, cells = {2: (mesh.create_unit_square, (1, 1)), 3: (mesh.create_unit_cube, (1, 1, 1))}[dimension]
    domain = create(MPI.COMM_SELF, *cells, kind)
    generator = np.random.default_rng(seed)
    stretched = generator.uniform(-1.0, 1.0, (dimension, dimension)) + 2.0 * np.eye(dimension)
    domain.geometry.x[:, :dimension] = (
        domain.geometry.x[:, :dimension] @ stretched * generator.uniform(0.1, 1.0, dimension)
    )
    advection = ufl.as_vector([fem.Constant(domain, value) for value in generator.uniform(-1.0, 1.0, dimension)])
    streamline = Streamline.of(
        Coordinates(domain, False),
        Carried(advection, fem.Constant(domain, conduction), fem.Constant(domain, exchange)),
        *(fem.Constant(domain, value) for value in (0.0, monotone)),
        straight=False,
        melts=melts,
    )
    assert isinstance(streamline.lumped, LumpedAtVertices)
    return domain, advection, streamline


def matrix_of(form):
    """The bilinear form as an array."""
    compiled = fem.form(form)
    matrix = fenicsx.create_matrix(compiled)
    fenicsx.assemble_matrix(matrix, compiled, [])
    return np.array(matrix.convert("dense").getDenseArray())  # a copy, as the matrix goes


@pytest.mark.parametrize("dimension", [2, 3])
def test_storage_of_monotone_simplices_is_lumped_at_their_vertices(dimension):
    """Storage and exchange couple no two nodes, and neither does what enters through the boundary."""
    domain, _, streamline = simplices(dimension)
    space = fenicsx.lagrange_space(domain)
    trial, test = ufl.TrialFunction(space), ufl.TestFunction(space)
    one = fem.Constant(domain, 1.0)
    for form in (
        streamline.stored(itself, trial, test) * ufl.dx,
        streamline.exchanged(one, trial, test) * ufl.dx,
        streamline.exchanged_downstream(one, trial, test) * ufl.dx,
        (trial * test + streamline.entered(one, trial, test)) * ufl.ds,
    ):
        found = matrix_of(form)
        assert found == pytest.approx(np.diag(np.diag(found)), abs=1e-14 * np.abs(found).max())
        assert (np.diag(found) > 0.0).all()


@pytest.mark.parametrize("dimension", [2, 3])
def test_simplices_that_become_monotone_keep_their_heat(dimension):
    heats = []
    for monotone in (0.0, 1.0):
        domain, _, streamline = simplices(dimension, monotone=monotone, melts=True)
        value, one = (fem.Function(fenicsx.lagrange_space(domain)) for _ in range(2))
        value.x.array[:] = np.linspace(1.0, 4.0, len(value.x.array))
        one.x.array[:] = 1.0
        heats.append(integral(streamline.stored(molten, value, one) * ufl.dx))
    assert heats[0] == pytest.approx(heats[1], rel=1e-12)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("seed", range(5))
def test_monotone_simplices_make_every_node_an_average_of_its_neighbours(dimension, seed):
    """No entry off the diagonal is positive, whatever the cell's shape, and a uniform temperature carries nothing away; in other
    cells there are positive ones."""

    def off_diagonal(monotone):
        numbers = {"conduction": 0.03, "exchange": 2.0, "monotone": monotone, "seed": seed}
        domain, advection, streamline = simplices(dimension, **numbers)
        space = fenicsx.lagrange_space(domain)
        trial, test = ufl.TrialFunction(space), ufl.TestFunction(space)
        form = streamline.carried(advection, trial, test)
        form += streamline.conducted(fem.Constant(domain, 0.03), trial, test)
        found = matrix_of(form * ufl.dx)
        assert np.abs(found.sum(axis=1)).max() < 1e-13 * np.abs(found).max()
        return (found - np.diag(np.diag(found))).max() / np.abs(found).max()

    assert off_diagonal(1.0) < 1e-13
    assert off_diagonal(0.0) > 1e-3


@pytest.mark.parametrize("angle", [0.0, 0.5, 1.2, 2.0, 3.0, -1.0])
def test_cells_of_any_mesh_are_lumped_along_their_own_sides(angle):
    """A quadrilateral turned by an angle, the flow nearly along its long side: the same as if it were not turned."""
    domain = box((1, 1), length=LENGTH, width=WIDTH)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    domain.mesh.geometry.x[:, :2] = domain.mesh.geometry.x[:, :2] @ turn
    flow = np.array([5.0, 0.1]) @ turn
    streamline = Streamline.of(
        Coordinates(domain.mesh, False),
        Carried(
            ufl.as_vector([fem.Constant(domain.mesh, value) for value in flow]),
            *(fem.Constant(domain.mesh, value) for value in (0.0, 40.0)),
        ),
        *(fem.Constant(domain.mesh, value) for value in (0.0, 1.0)),
        straight=False,
    )
    area = LENGTH * WIDTH
    sides = np.array([[LENGTH / 2.0, 0.0], [0.0, WIDTH / 2.0]]) @ turn
    reach = [integral(streamline.lumped.reach[axis] * domain.cell_measure(2)) / area for axis in (0, 1)]
    (half, square, _), *none = streamline.lumped.across
    across = [integral(half[axis] * domain.cell_measure(2)) / area for axis in (0, 1)]
    assert reach == pytest.approx(sides[0]) and np.abs(across) == pytest.approx(np.abs(sides[1]))
    assert square == 1.0 and not none


def test_upwinding_fades_where_conduction_or_exchange_wins():
    """chi is 1 for advection alone and tends to 0 with either."""

    def upwind(**numbers):
        _, dx, streamline = cell(monotone=0.0, **numbers)
        return integral(streamline.upwinded.upwind * dx) / (LENGTH * WIDTH)

    assert upwind(exchange=0.0) == pytest.approx(1.0, abs=1e-6)
    assert upwind(exchange=1e6) < 1e-3 and upwind(exchange=0.0, conduction=1e3) < 1e-3
    assert upwind(exchange=10.0) > upwind(exchange=100.0)
