r"""Planar, axisymmetric and three-dimensional calculus from one set of names.

Axisymmetric fields have x[0] = z along the axis and x[1] = r; a volume is 2 pi r dr dz (the whole pipe), and the
velocity gradient gains the hoop component u_r/r. Planar volumes are per metre of width; in three
dimensions everything is what it says.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import ufl
from dolfinx import fem

from ..laws.functions import Value
from ..mesh import fenicsx
from ..mesh.aliases import Mesh


@dataclass(frozen=True)
class Coordinates:
    """The measure and the differential operators of one kind of symmetry on one mesh."""

    mesh: Mesh
    axisymmetric: bool

    @property
    def weight(self) -> Value:
        """Factor of dx and ds: 2 pi r, or 1."""
        return 2.0 * math.pi * ufl.SpatialCoordinate(self.mesh)[1] if self.axisymmetric else 1.0

    @cached_property
    def from_middle(self) -> Value:
        """Vector from the middle of the cell (m)."""
        dimension = self.mesh.geometry.dim
        middle = fem.Function(fenicsx.cell_constant_space(self.mesh, dimension))
        middle.interpolate(lambda x: x[:dimension])
        return ufl.SpatialCoordinate(self.mesh) - middle

    @cached_property
    def nodal_weight(self) -> Value:
        """Factor of measures with quadrature at the nodes: what is lumped there of the volume, 2 pi (r + 2 r_cell)/3, so
        that the axis has its share."""
        if not self.axisymmetric:
            return 1.0
        radius = ufl.SpatialCoordinate(self.mesh)[1]
        return 2.0 * math.pi * (radius - 2.0 / 3.0 * self.from_middle[1])

    def velocity_gradient(self, velocity: Value) -> Value:
        """Gradient of a vector field as 2 x 2 tensor, or 3 x 3 with the hoop component u_r/r."""
        g = ufl.grad(velocity)
        if not self.axisymmetric:
            return g
        hoop = velocity[1] / ufl.SpatialCoordinate(self.mesh)[1]
        return ufl.as_tensor([[g[0, 0], g[0, 1], 0.0], [g[1, 0], g[1, 1], 0.0], [0.0, 0.0, hoop]])

    def strain_rate(self, velocity: Value) -> Value:
        """Symmetric part of the velocity gradient."""
        return ufl.sym(self.velocity_gradient(velocity))

    def shear_rate_squared(self, velocity: Value) -> Value:
        """2 S:S, the factor of mu_t in the production of turbulent kinetic energy."""
        strain = self.strain_rate(velocity)
        return 2.0 * ufl.inner(strain, strain)

    def stress(self, velocity: Value, viscosity: Value) -> Value:
        """Stress mu (grad u + grad u^T - 2/3 div u I) (thesis eq. 6.5)."""
        gradient = self.velocity_gradient(velocity)
        identity = ufl.Identity(3 if self.axisymmetric else self.mesh.geometry.dim)
        return viscosity * (gradient + gradient.T - (2.0 / 3.0) * ufl.tr(gradient) * identity)

    def meridional(self, tensor: Value) -> Value:
        """The part of a tensor that acts on vectors of the mesh's space."""
        if not self.axisymmetric:
            return tensor
        return ufl.as_tensor([[tensor[0, 0], tensor[0, 1]], [tensor[1, 0], tensor[1, 1]]])
