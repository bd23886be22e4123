"""The stations of a mesh of one's own: points on the wall's side to the bed, and beside it on the outer side and in the bed.

In a plane they lie at a fraction of the length along the interface, and the points beside them are the nearest of the outer wall
and of the plane of symmetry. In space they lie at a fraction of the interface's extent along x[0], and the centre of the bed is
where the wall's normal is farthest from the wall: at a plane of symmetry, at the axis of a pipe.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from ..arrays import Booleans, Floats
from .distances import (
    along_line_to,
    are_plane,
    distance_to_facets,
    distances_from,
    nearest_on_facets,
    normals_towards,
)
from .domain import INLET, INTERFACE, OUTER, OUTLET, SIDE, SYMMETRY, Stations

Facets = Mapping[int, Floats]
"""Corners (facets, corners, coordinates) of the boundary's parts, by tag, in m."""
ROUNDING = 1e-9
"""Of places, over the extent of the wall."""
ACROSS = 0.7
"""Cosine of the angle to a facet's normal below which another one's is that of another surface."""
NEAREST = 1e-6
"""Of the extent of the wall: how long a line into the bed is at least, how far a station is beside the place that is asked for
(which may be that of a corner), and within which distances from the wall count as equal."""
STEPS_INWARDS = 128
"""In which a wall's normal is followed into the bed."""


@dataclass(frozen=True)
class Surface:
    """All around the bed: corners of its facets (facets, corners, 3), the middles of the cells behind them, and which of them are
    of the wall."""

    corners: Floats
    behind: Floats
    of_wall: Booleans

    def inwards(self, place: Floats, rounding: float) -> Floats | None:
        """Unit normal into the bed at a place on its wall: the mean of those of the facets there that are nearly alike, along
        other planes that bound the bed there, too; None of a wall within the bed."""
        at_place = np.flatnonzero(distances_from(place, self.corners) <= rounding)
        if not self.of_wall[at_place].any():
            return None
        normals = normals_towards(self.behind[at_place], self.corners[at_place])
        alike = normals @ normals[np.argmax(self.of_wall[at_place])] > ACROSS
        mean = normals[alike].mean(axis=0)
        for plane in normals[~alike & ~self.of_wall[at_place]]:
            mean = mean - (plane @ mean) * plane
        return np.asarray(mean / np.linalg.norm(mean))


def stations_along_curve(facets: Facets) -> tuple[float, Stations]:
    """Length (m) along a plane bed's interface, and its stations at a fraction of that; of several walls along the longest."""
    corners = longest_chain(facets[INTERFACE], facets[INLET].reshape(-1, 2).mean(axis=0))
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])

    def stations(fraction: float) -> dict[str, tuple[float, ...]]:
        bed_side = np.array([np.interp(fraction * along[-1], along, corners[:, i]) for i in range(2)])
        beside = {"outer": OUTER, "centre": SYMMETRY}
        points = {name: nearest_on_facets(bed_side, facets[tag]) for name, tag in beside.items() if tag in facets}
        return {name: tuple(point) for name, point in {"bed_side": bed_side, **points}.items()}

    return float(along[-1]), stations


def longest_chain(segments: Floats, inlet: Floats) -> Floats:
    """Corners, one after the other, of the longest connected part of segments (n, 2, 2), from its end that is nearer to the
    inlet's middle."""
    nodes, ends = np.unique(segments.reshape(-1, 2), axis=0, return_inverse=True)
    pairs = np.unique(np.sort(ends.reshape(-1, 2), axis=1), axis=0)
    graph = coo_matrix((np.ones(len(pairs)), tuple(pairs.T)), shape=(len(nodes), len(nodes)))
    part = connected_components(graph, directed=False)[1]
    lengths = np.linalg.norm(nodes[pairs[:, 0]] - nodes[pairs[:, 1]], axis=1)
    along = np.bincount(part[pairs[:, 0]], weights=lengths)
    heights = np.bincount(part, weights=nodes[:, 1]) / np.bincount(part)
    alike = along >= (1.0 - ROUNDING) * along.max()
    longest = np.argmax(np.where(alike, heights, -np.inf))  # the upper one of them
    neighbours: dict[int, list[int]] = {}
    for first, last in pairs[part[pairs[:, 0]] == longest].tolist():
        neighbours.setdefault(first, []).append(last)
        neighbours.setdefault(last, []).append(first)
    tips = [node for node, beside in neighbours.items() if len(beside) == 1] or list(neighbours)
    chain = [min(tips, key=lambda node: float(np.linalg.norm(nodes[node] - inlet)))]
    visited = set(chain)
    while ahead := [node for node in neighbours[chain[-1]] if node not in visited]:
        chain.append(ahead[0])
        visited.add(ahead[0])
    return np.asarray(nodes[chain])


def stations_along_surface(facets: Facets, bed: Surface) -> tuple[float, Stations]:
    """Extent (m) of an interface in three dimensions along x[0], and its stations from the inlet's end, given the surface of the
    bed: where the interface is nearest to the plane `side` or, without that, half-way across x[2]; of two walls there on the
    upper one."""
    nodes = facets[INTERFACE].reshape(-1, 3)
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    rounding = ROUNDING * float((high - low).max())
    middle = 0.5 * (low[2] + high[2])
    if SIDE in facets:
        side = facets[SIDE].reshape(-1, 3)[:, 2].mean()
        middle = low[2] if side <= middle + rounding else high[2]
    ends = low[0], high[0]
    if facets[OUTLET].reshape(-1, 3)[:, 0].mean() < facets[INLET].reshape(-1, 3)[:, 0].mean():
        ends = high[0], low[0]

    def stations(fraction: float) -> dict[str, tuple[float, ...]]:
        place = ends[0] + fraction * (ends[1] - ends[0]) + NEAREST * (high[0] - low[0])  # beside the corner of a step
        place = np.clip(place, low[0] + rounding, high[0] - rounding)
        bed_side = _point_at(facets[INTERFACE], float(place), float(middle), rounding)
        named = {"bed_side": tuple(bed_side)}
        if OUTER in facets:
            named["outer"] = tuple(nearest_on_facets(bed_side, facets[OUTER]))
        inwards = bed.inwards(bed_side, 10.0 * rounding)
        if inwards is not None:
            named["centre"] = tuple(bed_side + _depth(bed_side, inwards, bed, facets[INTERFACE]) * inwards)
        return named

    return float(high[0] - low[0]), stations


def _point_at(facets: Floats, place: float, middle: float, rounding: float) -> Floats:
    """The point at x[0] = `place`, or where facets are nearest to that, that is nearest to x[2] = `middle`; the uppermost of
    several."""
    starts, stops = facets[:, :, 0].min(axis=1), facets[:, :, 0].max(axis=1)
    nearest_facet = np.argmin(np.maximum(starts - place, place - stops) + np.where(stops > starts, 0.0, np.inf))
    place = float(np.clip(place, starts[nearest_facet] + rounding, stops[nearest_facet] - rounding))
    ahead = facets[:, :, 0] > place
    crossed = ahead.any(axis=1) & ~ahead.all(axis=1)
    facets, ahead = facets[crossed], ahead[crossed]
    change = np.roll(facets, -1, axis=1) - facets
    part = (place - facets[:, :, 0]) / np.where(change[:, :, 0] == 0.0, np.inf, change[:, :, 0])
    points, crosses = facets + part[:, :, None] * change, ahead != np.roll(ahead, -1, axis=1)
    ends = np.array([found[sides][:2] for found, sides in zip(points, crosses, strict=True)])
    way = ends[:, 1] - ends[:, 0]
    share = np.clip((middle - ends[:, 0, 2]) / np.where(way[:, 2] == 0.0, np.inf, way[:, 2]), 0.0, 1.0)
    nearest = ends[:, 0] + np.where(are_plane(facets), share, np.round(share))[:, None] * way
    off = np.abs(nearest[:, 2] - middle)
    equal = np.flatnonzero(off <= off.min() + rounding)
    return np.asarray(nearest[equal[np.argmax(nearest[equal, 1])]])


def _depth(wall: Floats, inwards: Floats, bed: Surface, interface: Floats) -> float:
    """How far (m) the middle of the bed is from a point of the wall along its normal: there that is farthest from the wall, the
    last of several; 0 where it does not lead into the bed."""
    met = along_line_to(wall, inwards, bed.corners)
    extent = float(np.ptp(interface.reshape(-1, 3), axis=0).max())
    end = float(np.min(met, where=met > NEAREST * extent, initial=np.inf))
    if not np.isfinite(end):
        return 0.0
    depths = end * np.arange(1, STEPS_INWARDS + 1) / STEPS_INWARDS
    nearest = distance_to_facets(wall + depths[:, None] * inwards, interface)
    return float(depths[np.flatnonzero(nearest >= (1.0 - NEAREST) * nearest.max())[-1]])
