"""A droplet on a hot bed of grains: the ladder of checks from conduction and thrust to books, forces and regimes."""

import functools
import json
import math
import subprocess
import sys

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from porousmold.cli import main
from porousmold.errors import InputError
from porousmold.fluidised.column_beads import lattice
from porousmold.fluidised.column_grid import ColumnGrid
from porousmold.fluidised.droplet import Droplet
from porousmold.fluidised.droplet_beads import DropletBeads
from porousmold.fluidised.droplet_cli import PAPER_BEADS, PAPER_GAS
from porousmold.fluidised.droplet_column import BLOCKING, FULL, OF_THE_CIRCLE, DropletColumn
from porousmold.fluidised.droplet_gas import DropletGas, Surroundings
from porousmold.fluidised.droplet_input import DropletInput
from porousmold.laws.evaporation import BOILING_TEMPERATURE, LATENT_HEAT
from porousmold.laws.fluidisation import suspension_drag

SIZES = {
    "width": 8e-3, "depth": 0.25e-3, "height": 20e-3, "bed_height": 9.5e-3, "bead_diameter": 0.25e-3,
    "droplet_diameter": 2.5e-3, "release_height": 1.5e-3, "grain_diameter": 55e-6,
}  # fmt: skip


def given(celsius=400.0, **settings):
    return DropletInput(**{**SIZES, **PAPER_GAS, **PAPER_BEADS, "initial_temperature": celsius + 273.15, **settings})


def small(celsius=400.0, **settings):
    """A bed of few parcels that a droplet just fits into."""
    sizes = {"width": 5e-3, "height": 20e-3, "bed_height": 4e-3, "droplet_diameter": 2e-3, "release_height": 1.2e-3}
    return given(celsius, **{**sizes, **settings})


@functools.cache
def at_rest(seed=1):
    """Places and filling of the parcels of a small bed, which take seconds to come to rest."""
    beads = DropletBeads.at_rest(small(seed=seed))
    return beads.given.bead_diameter * beads._body[:, :3], beads.fill


def column_of(celsius=400.0, **settings):
    box = small(celsius, **settings)
    places, fill = at_rest()
    return DropletColumn(box, DropletBeads(box, places.copy(), fill))


@pytest.fixture(scope="module")
def run():
    """A droplet that has come down onto a bed at 400 °C."""
    column = column_of()
    column.integrate(0.15)
    return column


@pytest.mark.parametrize(("cells_a_radius", "error"), [(3.33, 0.03), (5.0, 0.02), (10.0, 0.01)])
@pytest.mark.parametrize("place", [(0.14e-3, 6.1e-3), (-0.03e-3, 5.87e-3), (0.31e-3, 6.22e-3)])
def test_conduction_to_the_circle(place, cells_a_radius, error):
    """From a ring of four radii, wherever it lies on the grid: 2 pi k dT/ln 4."""
    radius = 1.25e-3
    box = given(width=12e-3, height=12e-3, bed_height=4e-3, cell_size=radius / cells_a_radius / 0.25e-3)
    grid = ColumnGrid(box)
    droplet, gas = Droplet(box, grid, 3e-3), DropletGas(box, grid)
    droplet.place[:] = place
    up, across = (np.linspace(low, low + length, n + 1) for low, length, n in
                  zip((0.0, -6e-3), grid.lengths, grid.cells, strict=True))  # fmt: skip
    far = np.hypot(up[:, None] - droplet.place[1], across - droplet.place[0]) > 4.0 * radius
    free, conductivity = droplet.is_free(), np.full(far.shape, 0.026)
    held, hot = droplet.held(free, 0.026), 1e3 * 0.026 / (grid.lengths[1] / grid.cells[1]) ** 2 * far
    gas.porosity[:] = 1.0
    object.__setattr__(box, "relative_step", 1e6)  # steady
    nothing = np.zeros(far.shape)
    gas.keep()
    faces = droplet.between(conductivity, free)
    heat = held + hot, held * BOILING_TEMPERATURE + hot * 673.15
    gas.transport(nothing, faces, heat, faces, (nothing + 1.0, nothing))
    flow = (held * (gas.temperature - BOILING_TEMPERATURE) * grid.volumes).sum() / box.depth
    exact = 2.0 * math.pi * 0.026 * (673.15 - BOILING_TEMPERATURE) / math.log(4.0)
    assert flow == pytest.approx(exact, rel=error)


def heat_by_radial_conduction(radius, outer, conductivity, capacity, time):
    """To a circle that is at 0 in a medium of 1, J/m/K, up to a time (s): finite volumes, twice as fine as matters."""
    faces = np.geomspace(radius, outer, 300)
    nodes = np.concatenate([[radius], 0.5 * (faces[1:] + faces[:-1])])
    volumes = 0.5 * np.diff(faces**2)
    conductances = conductivity * np.concatenate([faces[:1], faces[1:-1]]) / np.diff(nodes)

    def rate(_, values):
        flux = conductances * np.diff(np.concatenate([[0.0], values[:-1]]))
        gained = (np.append(flux[1:], 0.0) - flux) / (volumes * capacity)
        return np.append(gained, flux[0])

    start = np.append(np.ones(len(volumes)), 0.0)
    solved = solve_ivp(rate, (0.0, time), start, method="BDF", rtol=1e-6, atol=1e-9)
    return 2.0 * math.pi * solved.y[-1, -1]


@pytest.mark.parametrize(("cell_size", "error"), [(1.5, 0.1), (1.0, 0.06)])
def test_heat_from_a_bed_at_rest_is_conducted(cell_size, error):
    """What grains on a lattice give to a circle among them in 0.2 s: not that their exchange with the nodes mixes them."""
    box = given(cell_size=cell_size, relative_step=0.2)
    places = lattice(box)[0]
    share = len(places) * math.pi / 6.0 * 0.25e-3**3 / (box.width * box.depth * places[:, 2].max())
    centre = np.array([0.05e-3, 5.1e-3])
    outside = np.hypot(*(places[:, [0, 2]] - centre).T) > 1.25e-3
    column = DropletColumn(box, DropletBeads(box, places[outside], 0.4 / share))
    column.droplet.place[:] = centre
    nothing, heat, time = np.zeros_like(column.gas.pressure), 0.0, 0.0
    while time < 0.2:
        column.gas.keep()
        placed = column._place()
        column.gas.up[:], column.gas.across[:] = 0.0, 0.0
        heat += column.heat.exchange(placed, nothing)[0] * box.time_step / box.depth
        time += box.time_step
    conductivity = float(column.heat.conductivity(np.array(0.4)))
    exact = heat_by_radial_conduction(1.25e-3, 4e-3, conductivity, 0.4 * 3200.0 * 290.0, time)
    assert heat == pytest.approx(exact * (673.15 - BOILING_TEMPERATURE), rel=error)


def velocity_at_source(above, below, width, images=12):
    """Upward velocity at a line source of unit strength in a box by its images: p = 0 `above` it, closed `below` and aside."""
    found = {0.0: 1.0}
    latest = dict(found)
    for _ in range(images):
        new = {}
        for at, sign in latest.items():
            for mirrored, other in ((2.0 * above - at, -sign), (-2.0 * below - at, sign)):
                if round(mirrored, 9) not in found:
                    found[round(mirrored, 9)] = new[round(mirrored, 9)] = other
        latest = new
    rows = [
        -sign * math.copysign(1.0 / math.tanh(math.pi * abs(at) / width) - 1.0, at) for at, sign in found.items() if at
    ]
    return (1.0 + sum(rows)) / (2.0 * width)


@pytest.mark.parametrize(("cell_size", "error"), [(1.5, 0.06), (1.0, 0.03), (0.6, 0.02)])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.07e-3, -0.05e-3), (-0.13e-3, 0.16e-3)])
def test_thrust_of_vapour_in_a_fixed_bed(shift, cell_size, error):
    """Vapour that leaves the circle evenly under a free surface: 2 pi R^2 U mu/K with the velocity U of its images."""
    width = 20e-3
    above, below = 4e-3 - shift[1], 10e-3 + shift[1]
    box = given(width=width, height=above + below, bed_height=8e-3, cell_size=cell_size)
    grid = ColumnGrid(box)
    droplet, gas = Droplet(box, grid, 5e-3), DropletGas(box, grid)
    droplet.place[:] = shift[0], below
    circle = droplet.share()
    coefficient = float(suspension_drag(0.5, box.grain_diameter, box.density, box.viscosity, 0.0))
    still, held = np.zeros_like(circle), np.full_like(circle, 1e30)
    gas.surround(Surroundings(
        beads=0.5 * (1.0 - circle), droplet=OF_THE_CIRCLE * circle, bead_velocity=[still, still],
        drag=coefficient * (1.0 - circle), theta=still, resistance=held, droplet_velocity=[0.0, 0.0],
        droplet_yielding=still, droplet_resistance=BLOCKING * (circle > FULL)))  # fmt: skip
    strength = 2.0 * math.pi * droplet.radius * 0.03
    object.__setattr__(box, "relative_step", 1e6)
    gas.flow(droplet.source(strength * box.depth, circle))
    per_velocity = coefficient / 0.5**2
    exact = 2.0 * math.pi * droplet.radius**2 * strength * velocity_at_source(above, below, width) * per_velocity
    across, up = droplet.pressure_force(gas.pressure) / box.depth
    assert up == pytest.approx(exact, rel=error)
    assert abs(across) < error * up


def test_mass_and_heat_are_conserved(run):
    assert abs(run.rows[-1]["heat_imbalance"]) < 1e-10
    assert abs(run.rows[-1]["vapour_imbalance"]) < 1e-10
    boiled = sum(row["heat_by_gas"] + row["heat_by_beads"] for row in run.rows) * run.given.time_step / LATENT_HEAT
    gone = (1.0 - run.rows[-1]["water"]) * run._water_at_first
    assert gone == pytest.approx(boiled - run.evaporation * run.given.time_step, rel=1e-9)
    assert run.rows[-1]["water"] < 0.99


def test_temperatures_stay_between_droplet_and_bed(run):
    for values in (run.gas.temperature, run.beads.temperature):
        assert values.min() >= BOILING_TEMPERATURE - 1e-6 and values.max() <= 673.15 + 1e-6
    assert run.gas.vapour.min() >= -1e-9 and run.gas.vapour.max() <= 1.0 + 1e-9
    assert run.beads.temperature.min() < 0.5 * (673.15 + BOILING_TEMPERATURE)  # of those that were inside


def test_the_floor_carries_what_the_gas_does(run):
    """Pressure at the floor, times its area, is the gas's force on grains and droplet, in the mean."""
    late = run.rows[len(run.rows) // 3 :]
    floor, beads, droplet = (
        np.mean([row[name] for row in late]) for name in ("force_on_floor", "force_on_beads", "force_by_gas")
    )
    assert beads + droplet == pytest.approx(floor, rel=0.05)


def test_forces_on_a_droplet_that_rests_carry_its_weight():
    """On a bed too cold to dig in, after it has come to rest."""
    column = column_of(200.0)
    column.integrate(0.4)
    late = column.rows[len(column.rows) // 2 :]
    force = np.mean([(row["force_by_gas"] + row["force_by_beads"]) / row["weight"] for row in late])
    assert force == pytest.approx(1.0, abs=0.02)


def test_a_grain_in_the_water_takes_its_temperature():
    """exp(-t/tau) with tau = rho_s C d^2/(12 lambda_w) = 0.344 ms."""
    column = column_of()
    places = column.beads.places
    column.droplet.place[:] = places[np.argmin(np.abs(places - (0.0, 2e-3)).sum(axis=1))]
    inside = column.droplet.is_inside(places)
    before = column.beads.temperature[inside].copy() - BOILING_TEMPERATURE
    column.gas.keep()
    column.heat.exchange(column._place(), np.zeros_like(column.gas.pressure))
    left = (column.beads.temperature[inside] - BOILING_TEMPERATURE) / before
    tau = 3200.0 * 290.0 * 55e-6**2 / (12.0 * column.droplet.water.conductivity)
    assert tau == pytest.approx(0.344e-3, rel=0.01)
    assert left == pytest.approx(np.full(inside.sum(), math.exp(-column.given.time_step / tau)), rel=1e-6)


def test_water_and_grains_give_each_other_the_same_momentum():
    column = column_of()
    beads, droplet = column.beads, column.droplet
    places = beads.places
    droplet.place[:] = places[np.argmin(np.abs(places - (0.0, 2e-3)).sum(axis=1))]
    droplet.velocity[:] = 0.02, -0.05
    beads.in_water = beads.by_name(800.0 * droplet.is_inside(places))
    total = lambda: droplet.mass * droplet.velocity + beads.mass * np.array([v.sum() for v in beads.velocity[::-1]])  # noqa: E731
    before = total()
    beads._drag_by_water(droplet, 1e-4)
    assert total() == pytest.approx(before, rel=1e-12)
    assert np.abs(droplet.velocity - (0.02, -0.05)).max() > 1e-3


def test_vapour_keeps_hot_grains_out():
    column = column_of(contact="film")
    column.integrate(0.06)
    assert max(row["beads_inside"] for row in column.rows) <= 2.0
    assert column.depth < 0.0


def test_grains_that_are_bonded_do_not_part():
    """Two parcels in contact that move apart slowly: a bond of five weights stops them."""
    box = small(bond=100.0)
    places = np.array([[0.0, 0.0, 2e-3], [0.0, 0.0, 2e-3 + 0.249e-3]])
    apart = {}
    for bond in (0.0, 5.0):
        beads = DropletBeads(box, places.copy())
        beads.bonds[:] = bond
        beads._body[:, 5] = [-0.05, 0.05]  # they part slowly
        beads.move([np.zeros(2)] * 2, [np.zeros(2)] * 2, np.zeros(2))
        apart[bond] = np.ptp(beads.places[:, 1]) / box.bead_diameter
    assert apart[0.0] > 1.0 > apart[5.0]


def test_a_run_goes_on_from_its_checkpoint_to_the_same_numbers(tmp_path):
    whole, first = column_of(), column_of()
    whole.integrate(0.03)
    first.integrate(0.015)
    first.save(tmp_path / "checkpoint.npz", {})
    with np.load(tmp_path / "checkpoint.npz") as file:
        second = DropletColumn.restored(small(), {name: file[name] for name in file.files})
    second.integrate(0.03)
    assert second.rows == whole.rows
    assert np.array_equal(second.beads.places, whole.beads.places)


def test_a_bed_that_water_would_wet_is_refused():
    with pytest.raises(InputError, match=r"bed-temperature.*wets"):
        given(120.0)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"bead_diameter": 50e-6}, "--parcel-diameter"),
        ({"bead_diameter": 1e-3}, "--parcel-diameter"),
        ({"width": 4e-3}, "--width"),
        ({"bed_height": 1e-3}, "--bed-height"),
        ({"height": 12e-3}, "--height"),
        ({"cell_size": 4.0}, "--cell-size"),
        ({"solid_fraction": 0.1}, "--solid-fraction"),
        ({"conduction": "metal"}, "--conduction"),
        ({"contact": "none"}, "--contact"),
        ({"drag": "none"}, "--drag"),
        ({"bond": -1.0}, "--bond"),
        ({"relative_step": 5.0}, "--relative-step = 5.0: must be <= 0.5"),
    ],
)
def test_input_that_does_not_fit_is_refused(settings, message):
    with pytest.raises(InputError, match=message):
        given(**settings)


def test_more_grains_than_parcels_hold_are_refused():
    with pytest.raises(InputError, match="that of the parcels"):
        DropletColumn(small(solid_fraction=0.6))


SMALL = [
    "--width",
    "5 mm",
    "--height",
    "20 mm",
    "--bed-height",
    "4 mm",
    "--droplet-diameter",
    "2 mm",
    "--time",
    "0.02 s",
]


def test_the_command_writes_history_result_and_pictures(tmp_path, capsys):
    assert not main(["droplet", *SMALL, "--release-height", "1.2 mm", "--animate", "--out", str(tmp_path)])
    text = capsys.readouterr().out
    result = json.loads((tmp_path / "result.json").read_text())
    assert f"{1e3 * result['depth']:.2f} mm" in text and "research model" in text
    assert (tmp_path / "droplet.png").stat().st_size > 10_000 and (tmp_path / "droplet.gif").exists()
    header = (tmp_path / "history.csv").read_text().splitlines()[0]
    assert header.startswith("time [s],depth [m],speed [m/s]")
    assert not (tmp_path / "checkpoint.npz").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--bed-temperature", "100 degC"], "--bed-temperature"),
        (["--time", "0 s"], "--time"),
        (["--width", "-1 mm"], "--width"),
        (["--beads", "cheese"], "--beads"),
        (["--friction", "many"], "--friction"),
        (["--seed", "1.5"], "--seed"),
    ],
)
def test_bad_arguments_end_in_one_line(arguments, message, tmp_path, capsys):
    assert main(["droplet", *SMALL, *arguments, "--out", str(tmp_path / "new")]) == 2
    error = capsys.readouterr().err
    assert message in error and len(error.strip().splitlines()) == 1
    assert not (tmp_path / "new").exists()


def test_a_droplet_digs_into_a_hot_bed_and_stays_on_a_cooler_one():
    """The paper's first two regimes. In a second a droplet digs more than half of its diameter deep at 400 °C and throws grains
    up. At 200 °C it throws none, and sinks slower than its water runs through grains at rest (Ergun: 0.9 mm/s)."""
    late, highest = {}, {}
    for celsius in (200.0, 400.0):
        column = DropletColumn(given(celsius))
        column.integrate(1.0)
        rows = [row for row in column.rows if row["time"] > 0.5]
        late[celsius] = np.array([row["depth"] for row in rows]) / column.given.droplet_diameter
        highest[celsius] = (max(row["highest_bead"] for row in rows) - column.surface) / column.given.droplet_diameter
    assert late[400.0][-400:].mean() > 0.5
    assert late[200.0][-400:].mean() < 0.5 * late[400.0][-400:].mean()
    assert (late[200.0][-1] - late[200.0][0]) * 2.5e-3 / 0.5 < 0.9e-3
    assert highest[200.0] < 0.5 < highest[400.0]


def test_no_module_of_petsc_is_needed():
    """The command starts without it: its gas is finite volumes."""
    code = "import sys; import porousmold.fluidised.droplet_column; print('petsc4py' in sys.modules, 'dolfinx' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    assert done.stdout.split() == ["False", "False"]
