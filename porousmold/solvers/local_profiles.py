"""Developed profiles at the nodes of any mesh, about the present pressure gradient there (`equations.locally_developed`)."""

import functools
from collections.abc import Callable

import numpy as np
from dolfinx import fem

from ..equations.locally_developed import NodalProfile, NodalProfiles
from ..laws.functions import Value
from ..mesh import ranks
from ..mesh.aliases import Space
from ..mesh.deferred_forms import DeferredForm
from ..mesh.domain import Domain
from ..mesh.point_values import nodal_values
from .developed_profiles import ProfileTable
from .nodal_means import NodalMeans

RELAXED = 0.5
"""Part by which relaxed profiles follow the pressure gradient of the nodes."""


class LocalProfiles:
    """`nodal` profiles of `count` fields over a scalar `space`, taken from the table that `make_table()` gives."""

    def __init__(
        self, domain: Domain, space: Space, means: NodalMeans, count: int, make_table: Callable[[], ProfileTable]
    ) -> None:
        self._domain, self._means, self._make_table = domain, means, make_table
        fields = tuple(NodalProfile(fem.Function(space), fem.Function(space)) for _ in range(count))
        self.nodal = NodalProfiles(fem.Function(space), fields)
        self._distance = np.maximum(nodal_values(domain.wall_distance, space), 0.0)
        self._farthest = ranks.largest_magnitude(domain.communicator, self._distance)
        self._logarithm_form: DeferredForm | None = None

    def follow(self, logarithm: Value) -> None:
        """Have the profiles be taken about the nodes' means of an expression, the logarithm of G."""
        self._logarithm_form = DeferredForm(self._means.form(logarithm))

    @functools.cached_property
    def table(self) -> ProfileTable:
        """Profiles against wall distance and pressure gradient."""
        return self._make_table()

    @property
    def functions(self) -> dict[str, fem.Function]:
        """All that they are kept in, by name."""
        parts = {
            f"{part}_{number}": getattr(one, part)
            for number, one in enumerate(self.nodal.fields)
            for part in ("value", "slope")
        }
        return {"logarithm": self.nodal.logarithm} | parts

    def renew(self, *, uniform: bool, relaxed: bool) -> None:
        """Take them about the present pressure gradient (collective); where `uniform` those that far from walls everywhere,
        whatever the gradient. Raises `SolveError` where they are not found."""
        assert self._logarithm_form is not None, "follow() comes first"
        logarithm = self.nodal.logarithm
        before = logarithm.x.array.copy()
        self._means.take(self._logarithm_form.form, logarithm)
        if relaxed:
            logarithm.x.array[:] = before + RELAXED * (logarithm.x.array - before)
        volumes = self._means.volumes
        owned = logarithm.x.array[: len(volumes)]
        sums = ranks.total(self._domain.communicator, [np.sum(volumes * owned), np.sum(volumes)])
        mean = float(sums[0] / sums[1])
        self.table.cover(mean)
        if uniform:
            logarithm.x.array[:] = mean
        distance = np.full_like(self._distance, self._farthest) if uniform else self._distance
        for number, ((values, slopes), field) in enumerate(
            zip(self.table.at(distance, logarithm.x.array), self.nodal.fields, strict=True)
        ):
            if number == 0:  # m is the scaled speed over G
                values, slopes = values * np.exp(-logarithm.x.array), slopes - 1.0
            field.value.x.array[:] = values
            field.slope.x.array[:] = 0.0 if uniform else slopes
