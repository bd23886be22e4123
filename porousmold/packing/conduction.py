r"""Conduction through a packing at rest, as a network of isothermal beads across the gap of a slab.

Two beads of radius R exchange heat where their Voronoi cells share a face: in lines parallel to that of their centres, through
the two cones between the centres and the disc of the face's area (radius r_ij), as far as these lie in the beads, and the fluid
between the beads, with a gap 2 H at the axis (after Cheng, Yu, Zulli, Chem. Eng. Sci. 54 (1999) 4199-4209, whose lines end
at the rim of the cones, R r_ij/sqrt(r_ij^2 + (R + H)^2)):

    h_lines = int_0^r* 2 pi r dr/{2 max[c - r (R + H)/r_ij, 0]/k_s + 2 (R + H - c)/k_f},
    c = sqrt(R^2 - r^2),   r* = min(R, r_ij).

A contact of radius a carries 2 (k_s - k_f) a besides (Batchelor, O'Brien, Proc. R. Soc. A 355 (1977) 313-333). These lines begin
on the cones, as if those were of one temperature. With k_s = k_f = 1 the pair should conduct G = A/(2 (R + H)) and conducts h_1.
So a resistance stands for the inside of the beads; where h_1 < G, a conductance for the fluid beside the lines:

    1/h = 1/[h_lines + 2 (k_s - k_f) a] + (1/G - 1/h_1)/k,   or   h = h_lines + 2 (k_s - k_f) a + (G - h_1) k,
    k = w k_s + (1 - w) k_f.

w is such that dh/dk_s at k_s = k_f is G times the share of the solid in the cones. Then equal conductivities give that
conductivity, and a small contrast the mean over the volume, which is exact.

Walls are mirrors, of which half a pair conducts; the ends of the part that is measured are mirrors without heat.

Beside resolved solutions of lattices (`docs/packed-conductivity.md`; conductivity ratios 2 to 1000, gaps of 0.5 and 2 % of the
spacing and contacts of 0.05 and 0.1 R) the network gives 0.86 to 1.04 for body- and face-centred lattices, 0.79 to 1.08 for
simple cubic ones.
Radiation and rarefied gas in the gaps are left out.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import spsolve
from scipy.spatial import Voronoi
from scipy.special import roots_legendre

from ..arrays import Booleans, Floats, Integers
from ..errors import InputError
from ..laws.conductivity import LocalBed, stagnant_conductivity
from .container import Slab
from .packing import Packing

_NODES, _WEIGHTS = roots_legendre(48)
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
REACH = 2.0
"""Bead diameters beyond the beads within which images are made."""
SMALLEST_FACE, LARGEST_GAP = 0.02, 1.0
"""Faces over bead radii, and gaps over diameters, of pairs that exchange heat."""
POISSON_RATIO = 0.3
"""Of beads in contact; 0.2 to 0.35 change the radius by 2 %."""
BEYOND_THE_TOP = 0.1
"""Bead diameters above the highest bead up to which a bed is evaluated."""
CORE = 3.0
"""Bead diameters from the walls on that count as the core."""


def line_conductance(
    radius: float,
    half_gap: Floats,
    face_radius: Floats,
    bead_conductivity: float,
    fluid_conductivity: float,
) -> Floats:
    """h_lines (W/K) of pairs of beads, by half of their gap and the radius of their face (m)."""
    return _in_parallel(_lines(radius, half_gap, face_radius), bead_conductivity, fluid_conductivity)


def pair_conductance(
    radius: float,
    half_gap: Floats,
    face_radius: Floats,
    bead_conductivity: float,
    fluid_conductivity: float,
    contact_radius: Floats | float = 0.0,
) -> Floats:
    """h (W/K) of pairs of beads, their inside included; `contact_radius` (m) of each, 0 where they do not touch."""
    reach, contrast = radius + half_gap, bead_conductivity - fluid_conductivity
    area, solid, fluid = lines = _lines(radius, half_gap, face_radius)
    outside = _in_parallel(lines, bead_conductivity, fluid_conductivity) + 2.0 * contrast * contact_radius
    whole, of_lines = np.pi * face_radius**2 / (2.0 * reach), _in_parallel(lines, 1.0, 1.0)
    in_solid = (area * solid / (solid + fluid) ** 2).sum(axis=0) / of_lines
    share = 2.0 * radius**3 * (1.0 - reach / np.hypot(reach, face_radius)) / (face_radius**2 * reach)
    less = np.minimum(whole, of_lines) / np.maximum(whole, of_lines)
    # where both are equal nothing stands beside or within the lines
    weight = np.clip((share - in_solid * less) / np.maximum(1.0 - less, 1e-12), 0.0, 1.0)
    other = weight * bead_conductivity + (1.0 - weight) * fluid_conductivity
    within = 1.0 / (1.0 / outside + np.maximum(1.0 / whole - 1.0 / of_lines, 0.0) / other)
    return np.where(of_lines > whole, within, outside + (whole - of_lines) * other)


def _lines(radius: float, half_gap: Floats, face_radius: Floats) -> tuple[Floats, ...]:
    """Of each line (nodes, pairs): its section (m2), and its length in the beads and in the fluid (m)."""
    reach, rim, s = radius + half_gap, np.minimum(radius, face_radius), _NODES[:, None]
    r, dr = rim * s**2, 2.0 * rim * s  # steep at the axis where beads touch
    height = np.sqrt(np.maximum(radius**2 - r**2, 0.0))
    area = _WEIGHTS[:, None] * 2.0 * np.pi * r * dr
    return area, 2.0 * np.maximum(height - r * reach / face_radius, 0.0), 2.0 * (reach - height)


def _in_parallel(lines: tuple[Floats, ...], bead_conductivity: float, fluid_conductivity: float) -> Floats:
    area, solid, fluid = lines
    return np.asarray((area / (solid / bead_conductivity + fluid / fluid_conductivity)).sum(axis=0))


@dataclass(frozen=True)
class Conduction:
    """Of a packing between two walls: `core` conductivity (W/m/K), `wall_coefficient` (W/m2/K) of the jump at a wall of the
    core's straight profile, `overall` conductivity from wall to wall, and the profile: `wall_distance` (m), `temperature` of
    the beads (0.5 and -0.5 at the walls), and `conductivity` (W/m/K) half way between each and the one before, or the wall
    (`conductivity_places`, m): with it the layers in series have the temperatures of the beads."""

    core: float
    overall: float
    wall_coefficient: float
    wall_distance: Floats
    temperature: Floats
    conductivity_places: Floats
    conductivity: Floats
    core_porosity: float


def conduction(
    packing: Packing,
    bead_conductivity: float,
    fluid_conductivity: float,
    *,
    contact_radius: float = 0.0,
    height: float | None = None,
    low: float = 0.0,
) -> Conduction:
    """Conduction across a slab between heights `low` and `height` (m; default: the levelled height), with conductivities of
    bead and fluid (W/m/K) and contacts of `contact_radius` (m) between beads that touch.

    Raises `InputError` for another container, beads of several sizes, fewer than 9 beads between the walls, or too low a part.
    """
    container, diameter = packing.container, packing.bead_diameter
    if not isinstance(container, Slab):
        raise InputError("PACKING", str(container), "must be a slab: heat is conducted from wall to wall")
    if np.ptp(packing.diameters) > 1e-6 * diameter:
        raise InputError("PACKING", f"{np.ptp(packing.diameters):g} m", "must hold beads of one size")
    if container.gap < (2.0 * CORE + 3.0) * diameter:
        raise InputError("PACKING", container.gap, f"must be at least {2.0 * CORE + 3.0:g} bead diameters wide")
    high = packing.levelled_height if height is None else height
    lowest = float(packing.positions[:, 2].min()) - 0.5 * diameter
    if lowest > low + diameter:
        raise InputError(
            "packing", f"{lowest - low:.4g} m", "lies between the floor and the lowest bead: is --floor missing?"
        )
    if not low + 4.0 * diameter <= high <= packing.top + BEYOND_THE_TOP * diameter:
        allowed = f"must leave at least {4.0 * diameter:g} m of bed, and be <= {packing.top:.4g} m, its top"
        raise InputError("--bed-height", high, allowed)
    inside = (packing.positions[:, 2] > low) & (packing.positions[:, 2] < high)
    beads = packing.positions[inside]
    first, second, areas, distances, is_wall = _faces(beads, container, diameter, low, high)
    gaps = np.maximum(distances - diameter, 0.0)
    face_radius = np.sqrt(areas / np.pi)
    kept = (face_radius > SMALLEST_FACE * 0.5 * diameter) & (gaps < LARGEST_GAP * diameter)
    first, second, gaps, face_radius, is_wall = (a[kept] for a in (first, second, gaps, face_radius, is_wall))
    contacts = np.where(gaps <= 1e-9 * diameter, contact_radius, 0.0)
    pairs = pair_conductance(0.5 * diameter, 0.5 * gaps, face_radius, bead_conductivity, fluid_conductivity, contacts)
    return _solved(beads, container, diameter, high - low, first, second, pairs, is_wall)


def hertz_contact_radius(
    pressure: float, youngs_modulus: float, diameter: float, solid_fraction: float, coordination_number: float
) -> float:
    """Radius (m) of the contacts of elastic beads under a pressure (Pa): a^3 = 3 F R (1 - nu^2)/(4 E) of Hertz with the mean
    force F = pi d^2 p/((1 - phi) Z) of Rumpf, for Young's modulus E (Pa) and `POISSON_RATIO`. Raises `InputError` where no beads
    touch."""
    if not coordination_number > 0.0:
        raise InputError("--pressure", pressure, "has no contacts to act on: no beads of the packing touch")
    force = np.pi * diameter**2 * pressure / (solid_fraction * coordination_number)
    return float((0.375 * force * diameter * (1.0 - POISSON_RATIO**2) / youngs_modulus) ** (1.0 / 3.0))


def zehner_bauer_schluender(
    porosity: float, diameter: float, bead_conductivity: float, fluid_conductivity: float
) -> float:
    """Conductivity (W/m/K) of a bed of spheres that touch in points, without radiation (`laws.conductivity`)."""
    bed = LocalBed(
        porosity=porosity,
        wall_distance=1e3 * diameter,
        bead_diameter=diameter,
        density=1.0,
        viscosity=1.0,
        heat_capacity=1.0,
        speed=0.0,
        eddy_viscosity=0.0,
        fluid_conductivity=fluid_conductivity,
        bead_conductivity=bead_conductivity,
        bulk_porosity=porosity,
        core_speed=0.0,
        temperature=300.0,
        emissivity=0.0,
        contact_flattening=0.0,
    )
    return float(stagnant_conductivity(bed, porosity))


def _faces(
    beads: Floats, container: Slab, diameter: float, low: float, high: float
) -> tuple[Integers, Integers, Floats, Floats, Booleans]:
    """Faces of the Voronoi cells: the two beads, the area (m2), the distance of the centres (m), and whether it lies in a wall.

    Each pair stands once."""
    half_gap, reach = 0.5 * container.gap, REACH * diameter
    around, of = beads, np.arange(len(beads))
    for sign in (-1.0, 1.0):
        image = beads + np.array([0.0, sign * container.width, 0.0])
        near = np.abs(image[:, 1]) < 0.5 * container.width + reach
        around, of = np.concatenate([around, image[near]]), np.concatenate([of, np.flatnonzero(near)])
    around, of = _with_mirrors(around, of, 2, (low, high), reach)
    everything, of = _with_mirrors(around, of, 0, (-half_gap, half_gap), reach)
    is_mirror = np.arange(len(everything)) >= len(around)
    cells = Voronoi(everything)
    a, b = cells.ridge_points.T
    swap = a >= len(beads)
    a, b = np.where(swap, b, a), np.where(swap, a, b)
    used = np.flatnonzero(
        (a < len(beads)) & (~is_mirror[b] | (of[b] == a))
    )  # of mirrors only a bead's own faces the wall
    areas = np.array([_area(cells.vertices[cells.ridge_vertices[face]]) for face in used])
    a, b = a[used], b[used]
    once = (b < len(beads)) | is_mirror[b] | (a <= of[b])  # a periodic image is met from both of its beads
    a, b, areas = a[once], b[once], areas[once]
    return a, of[b], areas, np.linalg.norm(everything[a] - everything[b], axis=1), is_mirror[b]


def _with_mirrors(
    points: Floats, owners: Integers, axis: int, planes: tuple[float, float], reach: float
) -> tuple[Floats, Integers]:
    """Points with their mirror images beyond two planes across an axis, within the reach, and the beads that they belong to."""
    images, of = [points], [owners]
    for plane in planes:
        near = np.abs(points[:, axis] - plane) < reach
        image = points[near].copy()
        image[:, axis] = 2.0 * plane - image[:, axis]
        images.append(image)
        of.append(owners[near])
    return np.concatenate(images), np.concatenate(of)


def _area(corners: Floats) -> float:
    from_middle = corners - corners.mean(axis=0)
    return float(0.5 * np.linalg.norm(np.cross(from_middle, np.roll(from_middle, -1, axis=0)).sum(axis=0)))


def _solved(
    beads: Floats,
    container: Slab,
    diameter: float,
    height: float,
    first: Integers,
    second: Integers,
    pairs: Floats,
    is_wall: Booleans,
) -> Conduction:
    """Temperatures of the beads between walls at -0.5 and 0.5, and what follows."""
    count, across = len(beads), beads[:, 0]
    i, j, h = first[~is_wall], second[~is_wall], pairs[~is_wall]
    rows, columns = np.concatenate([i, j, i, j]), np.concatenate([j, i, i, j])
    matrix = coo_matrix((np.concatenate([-h, -h, h, h]), (rows, columns)), shape=(count, count)).tocsr()
    to_wall = np.zeros((count, 2))
    np.add.at(to_wall, (first[is_wall], (across[first[is_wall]] > 0.0).astype(int)), 2.0 * pairs[is_wall])
    matrix += diags(to_wall.sum(axis=1))
    temperature = spsolve(matrix.tocsc(), to_wall @ np.array([-0.5, 0.5]))
    flux = float((to_wall[:, 1] * (0.5 - temperature)).sum()) / (height * container.width)
    half = 0.5 * container.gap
    core = np.abs(across) < half - CORE * diameter
    if not np.isfinite(temperature).all() or not flux > 0.0:
        allowed = "must be one bed from wall to wall: no heat passes it (is the container as in the file?)"
        raise InputError("PACKING", str(container), allowed)
    slope, middle = np.polyfit(across[core], temperature[core], 1)
    jump = 0.5 - abs(slope) * half
    solid = core.sum() * np.pi / 6.0 * diameter**3
    core_volume = 2.0 * (half - CORE * diameter) * container.width * height
    distance, profile = _profile(half - np.abs(across), np.sign(across) * (temperature - middle), half, diameter)
    places, steps = np.concatenate([[0.0], distance]), np.diff(np.concatenate([[0.5], profile]))
    return Conduction(
        core=flux / float(slope),
        overall=flux * container.gap,
        wall_coefficient=flux / jump if jump > 0.0 else float("inf"),
        wall_distance=distance,
        temperature=profile,
        conductivity_places=0.5 * (places[1:] + places[:-1]),
        conductivity=flux * np.diff(places) / np.maximum(-steps, 1e-12),
        core_porosity=float(1.0 - solid / core_volume),
    )


def _profile(distance: Floats, temperature: Floats, half: float, diameter: float) -> tuple[Floats, Floats]:
    """Mean wall distance and temperature of the beads' layers, a bead diameter thick each."""
    edges = np.arange(0.0, half + 0.5 * diameter, diameter)
    layer = np.digitize(distance, edges)
    layers = [number for number in np.unique(layer) if (layer == number).sum() > 4]
    means = np.array([[distance[layer == n].mean(), temperature[layer == n].mean()] for n in layers])
    return means[:, 0], means[:, 1]
