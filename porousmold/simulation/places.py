"""The places of a problem: wall, its side to the bed, the bed, and the layers; how warm they are and where."""

from collections.abc import Mapping

import numpy as np
from dolfinx import fem

from ..arrays import Floats, Integers
from ..mesh import domain as geometry
from ..mesh import fenicsx, ranks
from ..mesh.domain import Domain
from ..scene.features.wall import Layer
from ..solvers.protocols import Heat
from .specs import HeatSpec

ROUNDING = 1e-12
"""Of places, over the length."""
SAME_TEMPERATURE = 1e-4
"""K, to which stages are solved: where all is alike, the places of the extremes are those of every number of ranks."""


class Places:
    """The nodes of each place by its name, and the present temperatures there."""

    def __init__(self, domain: Domain, heat: Heat, specs: HeatSpec) -> None:
        self._domain, self._heat, self._specs = domain, heat, specs
        self._numbers = self._numbers_of_places()
        self._along = self._places_along_the_flow()

    def _places_along_the_flow(self) -> Floats:
        """Distance along x[0] from the inlet's end of the bed (m) of every temperature of the heat's unknowns, without what
        rounding leaves at 0."""
        space, along = self._heat.space, np.zeros(len(self._heat.unknown.x.array))
        begin, end = self._domain.ends
        runs_back = self._domain.from_inlet_to_outlet[0] < 0.0
        parts = [(space, np.arange(len(along)))]
        if self._specs.model.two_temperatures:
            parts = [fenicsx.collapse(space, part) for part in range(2)]
        for part, numbers in parts:
            places = part.tabulate_dof_coordinates()[:, 0]
            places = end - places if runs_back else places - begin
            along[numbers] = np.where(np.abs(places) < ROUNDING * self._domain.length, 0.0, places)
        return along

    def _numbers_of_places(self) -> Mapping[str, Integers]:
        """Of the fluid and the wall, which have one temperature; of the bed also those of its beads."""
        phases = [self._heat.space.sub(part) for part in range(2)] if self._specs.model.two_temperatures else []
        space, *beads = phases or [self._heat.space]
        dimension, domain = self._domain.mesh.topology.dim, self._domain
        interface = fem.locate_dofs_topological(space, dimension - 1, domain.facets(geometry.INTERFACE))
        wall = fem.locate_dofs_topological(space, dimension, domain.wall_cells)
        places = {
            "wall": wall if domain.has_wall else interface,
            "bed_side": interface,
            "bed": np.concatenate(
                [fem.locate_dofs_topological(one, dimension, domain.cells(geometry.BED)) for one in (space, *beads)]
            ),
        }
        for tag, layer in self._layers:
            places[layer.name] = fem.locate_dofs_topological(space, dimension, domain.cells(tag))
        return places

    @property
    def _layers(self) -> list[tuple[int, Layer]]:
        """Tags and specs of the layers that have names of their own."""
        layers = zip(self._domain.wall_tags, self._specs.all_layers, strict=False)
        return [(tag, layer) for tag, layer in layers if layer.name != "wall" and not layer.is_contact]

    @property
    def names(self) -> list[str]:
        """Of all places."""
        return list(self._numbers)

    def extremes(self, place: str) -> tuple[float, float]:
        """Smallest and largest temperature (K) at 'wall', 'bed_side' or 'bed'."""
        return ranks.extremes(self._domain.communicator, self._heat.unknown.x.array[self._numbers[place]])

    def extreme_places(self, place: str) -> tuple[float, float]:
        """Distance along x[0] (m) of the coldest and of the hottest point of a place, the first along the flow of those that are
        no less so than by `SAME_TEMPERATURE` (collective)."""
        numbers, communicator = self._numbers[place], self._domain.communicator
        values, along = self._heat.unknown.x.array[numbers], self._along[numbers]
        first = [
            along[np.abs(values - extreme) <= SAME_TEMPERATURE].min(initial=np.inf) for extreme in self.extremes(place)
        ]
        low, high = -ranks.maximum(communicator, np.negative(first))
        return (float(low), float(high)) if np.isfinite([low, high]).all() else (0.0, 0.0)

    def step_at_the_inlet(self, place: str) -> float:
        """How far (K) the extremes of a place at the inlet are beyond those of all its other nodes; 0 where they are within
        (collective)."""
        numbers = self._numbers[place]
        values, along = self._heat.unknown.x.array[numbers], self._along[numbers]
        at_inlet = along <= 0.0
        (low, high), (least, most) = (
            ranks.extremes(self._domain.communicator, values[part]) for part in (at_inlet, ~at_inlet)
        )
        return max(high - most, least - low, 0.0) if np.isfinite([low, high, least, most]).all() else 0.0
