"""Facets (segments in a plane, triangles or quadrilaterals in space): their normals, distances to them, places on them."""

import itertools

import numpy as np
from scipy.spatial import cKDTree

from ..arrays import Booleans, Floats

FLAT = 1e-9
"""Distance of a quadrilateral's corner from the plane of the others, over its size, that rounding explains."""
PARALLEL = 1e-9
"""Cosine of the angle between a line and the normal of a facet along which it runs."""


def heights_of(facets: Floats) -> Floats:
    """Length (m) of segments (n, 2, coordinates); area over the longest side of triangles and quadrilaterals."""
    sides = np.linalg.norm(np.roll(facets, -1, axis=1) - facets, axis=2).max(axis=1)
    if facets.shape[1] == 2:
        return sides
    diagonals = facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0]
    if facets.shape[1] == 4:
        diagonals = facets[:, 2] - facets[:, 0], facets[:, 3] - facets[:, 1]
    return np.asarray(0.5 * np.linalg.norm(np.cross(*diagonals), axis=1) / np.maximum(sides, 1e-300))


def distance_to_facets(points: Floats, facets: Floats) -> Floats:
    """Distance (m) of points (n, coordinates) to the nearest of the facets (m, corners, coordinates): segments in a plane,
    triangles or quadrilaterals in space, each of these taken as two triangles."""
    facets = _triangles(facets)
    middles, radius = _middles_and_radius(facets)
    tree, result, open_points, count = cKDTree(middles), np.full(len(points), np.inf), np.arange(len(points)), 8
    while len(open_points):  # a facet whose middle lies beyond the distance found plus the radius is no nearer
        count = min(count, len(facets))
        reached, candidates = tree.query(points[open_points], k=np.arange(1, count + 1))
        result[open_points] = _distances(points[open_points], facets[candidates]).min(axis=1)
        is_open = (reached[:, -1] - radius < result[open_points]) & (count < len(facets))
        open_points, count = open_points[is_open], 2 * count
    return result


def _middles_and_radius(facets: Floats) -> tuple[Floats, float]:
    """Middles of facets, and the largest distance (m) of a corner from that of its facet."""
    middles = facets.mean(axis=1)
    return middles, float(np.linalg.norm(facets - middles[:, None], axis=2).max())


def _distances(points: Floats, facets: Floats) -> Floats:
    """Distance of every point (n, coordinates) to each of its facets (n, facets, corners, coordinates)."""
    corners = np.moveaxis(facets, 2, 0)
    place = points[:, None]
    result = np.min(
        [_to_segment(place, first, last) for first, last in itertools.combinations(corners, 2)], axis=0, initial=np.inf
    )
    if len(corners) == 3:
        first, second = corners[1] - corners[0], corners[2] - corners[0]
        normal = np.cross(first, second)
        square, offset = np.sum(normal**2, axis=-1), place - corners[0]
        weights = [np.sum(np.cross(offset, second) * normal, axis=-1) / square]
        weights.append(np.sum(np.cross(first, offset) * normal, axis=-1) / square)
        above = (weights[0] >= 0.0) & (weights[1] >= 0.0) & (weights[0] + weights[1] <= 1.0)
        result = np.where(above, np.abs(np.sum(offset * normal, axis=-1)) / np.sqrt(square), result)
    return result


def _to_segment(place: Floats, first: Floats, last: Floats) -> Floats:
    along, offset = last - first, place - first
    fraction = np.clip(np.sum(offset * along, axis=-1) / np.sum(along**2, axis=-1), 0.0, 1.0)
    return np.linalg.norm(offset - fraction[..., None] * along, axis=-1)


def unit_normals(facets: Floats) -> Floats:
    """Unit normals (facets, 3) of facets (facets, corners, 3): of a quadrilateral that of its diagonals, of a segment that in the
    plane."""
    if facets.shape[1] == 2:
        along = facets[:, 1] - facets[:, 0]
        normals = np.column_stack([-along[:, 1], along[:, 0], np.zeros(len(along))])
    else:
        last = facets[:, 3] - facets[:, 1] if facets.shape[1] == 4 else facets[:, 2] - facets[:, 1]
        normals = np.cross(facets[:, 2] - facets[:, 0], last)
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def normals_towards(places: Floats, facets: Floats) -> Floats:
    """Unit normals (facets, 3) of facets (facets, corners, 3), each to the side where a place of its own lies."""
    normals = unit_normals(facets)
    return np.asarray(normals * np.sign(np.einsum("nk,nk->n", normals, places - facets.mean(axis=1)))[:, None])


def are_plane(facets: Floats) -> Booleans:
    """Which of the facets have all their corners in one plane."""
    if facets.shape[1] < 4:
        return np.full(len(facets), fill_value=True)
    sides = facets[:, 1:] - facets[:, :1]
    off = np.einsum("nk,nk->n", np.cross(sides[:, 0], sides[:, 1]), sides[:, 2])
    return np.asarray(np.abs(off) <= FLAT * np.linalg.norm(sides, axis=2).max(axis=1) ** 3)


def distances_from(point: Floats, facets: Floats) -> Floats:
    """Distance (m) from a point to each of the facets in space; infinite to those that cannot be at it."""
    middles, radius = _middles_and_radius(facets)
    near, found = np.linalg.norm(middles - point, axis=1) <= 2.0 * radius, np.full(len(facets), np.inf)
    if not near.any():
        return found
    parts = _triangles(facets[near])
    found[near] = _distances(point[None], parts[None])[0].reshape(-1, near.sum()).min(axis=0)
    return found


def nearest_on_facets(point: Floats, facets: Floats) -> Floats:
    """The place on any of the facets that is nearest to a point; of quadrilaterals that are not plane, one on their sides."""
    middles, radius = _middles_and_radius(facets)
    reach = np.linalg.norm(middles - point, axis=1)
    facets = facets[reach <= reach.min() + radius]  # no other is nearer than the nearest middle
    first, sides = facets, np.roll(facets, -1, axis=1) - facets
    part = np.sum((point - first) * sides, axis=2) / np.maximum(np.sum(sides**2, axis=2), 1e-300)
    places = [(first + np.clip(part, 0.0, 1.0)[..., None] * sides).reshape(-1, len(point))]
    if facets.shape[1] > 2:
        plane = _triangles(facets[are_plane(facets)])
        if len(plane):
            normals = unit_normals(plane)
            off = np.einsum("nk,nk->n", plane[:, 0] - point, normals)
            inside = np.isfinite(_along_line(point, normals, plane))
            places.append(point + (off[:, None] * normals)[inside])
    candidates = np.concatenate(places)
    return np.asarray(candidates[np.argmin(np.linalg.norm(candidates - point, axis=1))])


def along_line_to(point: Floats, direction: Floats, facets: Floats) -> Floats:
    """Distances (m, below 0 backwards) from a point along a unit vector to the facets in space that this line meets; of
    quadrilaterals to both of their triangles."""
    middles, radius = _middles_and_radius(facets)
    offset = middles - point
    off = np.linalg.norm(offset - (offset @ direction)[:, None] * direction, axis=1)
    near = _triangles(facets[off <= radius * (1.0 + FLAT)])
    found = _along_line(point, np.broadcast_to(direction, (len(near), 3)), near)
    return found[np.isfinite(found)]


def _triangles(facets: Floats) -> Floats:
    if facets.shape[1] == 4:
        return np.concatenate([facets[:, [0, 1, 2]], facets[:, [0, 2, 3]]])
    return facets


def _along_line(point: Floats, directions: Floats, triangles: Floats) -> Floats:
    """Distance from a point to each triangle along its unit vector; infinite where it passes it (Moeller and Trumbore, J.
    Graphics Tools 2 (1997) 21-28)."""
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    across, offset = np.cross(directions, second), point - triangles[:, 0]
    size = np.einsum("nk,nk->n", first, across)
    crossed = np.abs(size) > PARALLEL * np.linalg.norm(np.cross(first, second), axis=1)
    size = np.where(crossed, size, 1.0)
    turned = np.cross(offset, first)
    one, other = np.einsum("nk,nk->n", offset, across) / size, np.einsum("nk,nk->n", directions, turned) / size
    inside = crossed & (one >= -FLAT) & (other >= -FLAT) & (one + other <= 1.0 + FLAT)
    return np.where(inside, np.einsum("nk,nk->n", second, turned) / size, np.inf)
