"""Conduction of packed beads beside resolved solutions: lattices of spheres, conforming tetrahedra, quadratic elements.

Writes docs/packed-conductivity.md. Run: make lattices (4 minutes). An eighth of the cubic cell of a lattice has planes of
symmetry on all sides; between the two across the gradient lie temperatures 0 and 1. The energy of the solution is the
conductivity.
"""

import argparse
import math
from dataclasses import dataclass
from pathlib import Path

import gmsh
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import LinearProblem
from mpi4py import MPI
from petsc4py import PETSc

from porousmold.mesh import fenicsx
from porousmold.packing.conduction import (
    conduction,
    hertz_contact_radius,
    pair_conductance,
    zehner_bauer_schluender,
)
from porousmold.packing.container import container
from porousmold.packing.generator import Mixture, pack
from studies.page import Page

DOCS = Path(__file__).parent.parent / "docs"
RATIOS = (2.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
GAPS = (0.02, 0.005, -0.00125, -0.005)
"""Between beads over the spacing of their centres; overlaps are contacts of 0.05 and 0.1 R."""
PRESSURE, STEEL, AIR = 2.2e3, 42.0, 0.0265
"""Of the measured steel bed, SI."""
FINEST, COARSEST, GROWTH = 0.004, 0.07, 0.15


@dataclass(frozen=True)
class Lattice:
    """Beads of the cubic cell with corners in the eighth [0, 1/2]^3, and the faces of their Voronoi cells: distance of the
    centres, area, and the factor of their conductance in the conductivity."""

    beads: tuple[tuple[float, float, float], ...]
    faces: tuple[tuple[float, float, float], ...]

    @property
    def spacing(self) -> float:
        """Of nearest centres."""
        return min(distance for distance, _, _ in self.faces)


LATTICES = {
    "simple cubic": Lattice(((0.0, 0.0, 0.0),), ((1.0, 1.0, 1.0),)),
    "body-centred": Lattice(
        ((0.0, 0.0, 0.0), (0.5, 0.5, 0.5)),
        ((math.sqrt(0.75), 3.0 * math.sqrt(3.0) / 16.0, 2.0), (1.0, 0.125, 2.0)),
    ),
    "face-centred": Lattice(
        ((0.0, 0.0, 0.0), (0.5, 0.5, 0.0), (0.5, 0.0, 0.5), (0.0, 0.5, 0.5)),
        ((math.sqrt(0.5), math.sqrt(2.0) / 8.0, 4.0),),
    ),
}


def network(lattice, gap, ratio):
    """Conductivity over that of the fluid, of `packing.conduction`'s pairs of beads."""
    spacing, radius = lattice.spacing, 0.5 * lattice.spacing * (1.0 - gap)
    contact = math.sqrt(max(radius**2 - 0.25 * spacing**2, 0.0))
    radius = min(radius, 0.5 * spacing)
    total = 0.0
    for distance, area, factor in lattice.faces:
        half_gap, face = np.array([0.5 * distance - radius]), np.array([math.sqrt(area / math.pi)])
        touching = contact if distance == spacing else 0.0
        total += factor * pair_conductance(radius, half_gap, face, ratio, 1.0, touching)[0]
    return total


def resolved(lattice, gap, ratios=RATIOS):
    """Conductivities over that of the fluid, and the share of solid in the mesh."""
    mesh, is_solid = _mesh(lattice, 0.5 * lattice.spacing * (1.0 - gap), abs(gap) * lattice.spacing)
    space, values = fenicsx.lagrange_space(mesh, 2), []
    conductivity = fem.Function(fenicsx.cell_constant_space(mesh))
    low, high = (fem.locate_dofs_geometrical(space, lambda x, at=at: np.isclose(x[2], at)) for at in (0.0, 0.5))
    fixed = [fem.dirichletbc(PETSc.ScalarType(value), dofs, space) for value, dofs in ((0.0, low), (1.0, high))]
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    form = conductivity * ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx
    source = fem.Constant(mesh, PETSc.ScalarType(0.0)) * v * ufl.dx
    options = {"ksp_type": "cg", "pc_type": "hypre", "ksp_rtol": 1e-10}
    for ratio in ratios:
        conductivity.x.array[:] = np.where(is_solid, ratio, 1.0)
        found = LinearProblem(form, source, bcs=fixed, petsc_options=options).solve()
        energy = fem.assemble_scalar(fem.form(conductivity * ufl.inner(ufl.grad(found), ufl.grad(found)) * ufl.dx))
        values.append(2.0 * energy)
    conductivity.x.array[:] = np.where(is_solid, 1.0, 0.0)
    return values, 8.0 * fem.assemble_scalar(fem.form(conductivity * ufl.dx))


def _mesh(lattice, radius, gap):
    """The eighth of the cell, fine where beads are near each other, and which of its cells are solid."""
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        shapes = gmsh.model.occ
        box = (3, shapes.addBox(0.0, 0.0, 0.0, 0.5, 0.5, 0.5))
        spheres = [(3, shapes.addSphere(*bead, radius)) for bead in lattice.beads]
        solids, _ = shapes.intersect([box], spheres, removeObject=False)
        _, parts = shapes.fragment([box], solids)
        shapes.synchronize()
        inside = sorted({tag for part in parts[1:] for dimension, tag in part if dimension == 3})
        outside = [tag for _, tag in gmsh.model.getEntities(3) if tag not in inside]
        gmsh.model.addPhysicalGroup(3, inside, 1)
        gmsh.model.addPhysicalGroup(3, outside, 2)
        _sizes(lattice, max(0.25 * gap, FINEST))
        gmsh.model.mesh.generate(3)
        mesh, cells, _ = fenicsx.mesh_of_gmsh(gmsh.model, MPI.COMM_SELF, 3)
    finally:
        gmsh.finalize()
    is_solid = np.zeros(mesh.topology.index_map(3).size_local, bool)
    is_solid[cells.indices] = cells.values == 1
    return mesh, is_solid


def _sizes(lattice, finest):
    """Cells that grow from the points half way between neighbours."""
    field, beads = gmsh.model.mesh.field, np.array(lattice.beads)
    middles = [0.5 * (a + b) for n, a in enumerate(beads) for b in beads[n + 1 :]] or list(0.5 * np.eye(3))
    fields = []
    for x, y, z in middles:
        fields.append(field.add("MathEval"))
        distance = f"Sqrt((x-{x})^2+(y-{y})^2+(z-{z})^2)"
        field.setString(fields[-1], "F", f"{finest}+{GROWTH}*{distance}")
    fields.append(field.add("MathEval"))
    field.setString(fields[-1], "F", str(COARSEST))
    smallest = field.add("Min")
    field.setNumbers(smallest, "FieldsList", fields)
    field.setAsBackgroundMesh(smallest)
    for source in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
        gmsh.option.setNumber(f"Mesh.MeshSize{source}", 0)


def main():
    """Compute the tables and write them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=DOCS / "packed-conductivity.md")
    out = parser.parse_args().out
    page = Page(
        "# Conductivity of packed beads",
        "",
        "Written by `make lattices`; do not edit. `porousmold conductivity` computes the conduction of a packing at rest as a",
        "network of beads (theory: `porousmold/packing/conduction.py`). Here it stands beside resolved solutions and published",
        "formulas.",
        "",
        "## Lattices of spheres",
        "",
        "The network over a resolved solution (conforming tetrahedra, quadratic elements) for conductivity ratios of beads and",
        "fluid. Gap: between beads, over the spacing of their centres; negative ones are contacts of 0.05 and 0.1 bead radii.",
    )
    page.head("lattice", "gap", "solid in the mesh", *(f"{ratio:g}" for ratio in RATIOS), "resolved at 1000")
    for name, lattice in LATTICES.items():
        for gap in GAPS:
            values, solid = resolved(lattice, gap)
            ratios = [f"{network(lattice, gap, r) / k:.2f}" for r, k in zip(RATIOS, values, strict=True)]
            page.row(name, f"{gap:g}", f"{solid:.4f}", *ratios, f"{values[-1]:.2f}")
    _poured(page)
    page.write(out)


def _poured(page):
    """A poured slab beside Zehner, Bauer and Schluender, bounds, and the measured steel bed."""
    packing = pack(container("slab", {"gap": 0.06, "width": 0.04}), Mixture((0.005,)), bed_height=0.07)
    porosity = conduction(packing, 2.0, 1.0, height=0.07).core_porosity
    page.add(
        "",
        "## A poured bed",
        "",
        f"Slab of 12 bead diameters, porosity of the core {porosity:.3f}; the network over Zehner, Bauer and Schluender (point",
        "contacts, no radiation; their scatter is 30 %), and over Hashin's and Shtrikman's bounds.",
    )
    page.head(
        "ratio", "gaps alone", "contacts of 0.003 R", "contacts of 0.01 R", "over lower bound", "over upper bound"
    )
    for ratio in (1.5, 3.0, *RATIOS[1:], 1700.0):
        plain = conduction(packing, ratio, 1.0, height=0.07)
        published = zehner_bauer_schluender(plain.core_porosity, 0.005, ratio, 1.0)
        touching = [conduction(packing, ratio, 1.0, height=0.07, contact_radius=a * 0.0025).core for a in (0.003, 0.01)]
        solid = 1.0 - plain.core_porosity
        lower = 1.0 + 3.0 * solid * (ratio - 1.0) / (ratio + 2.0 - solid * (ratio - 1.0))
        upper = ratio + plain.core_porosity / (1.0 / (1.0 - ratio) + solid / (3.0 * ratio))
        shares = [value / published for value in (plain.core, *touching)]
        page.row(
            f"{ratio:g}",
            *(f"{share:.2f}" for share in shares),
            f"{plain.core / lower:.3f}",
            f"{plain.core / upper:.3f}",
        )
    loose = pack(
        container("slab", {"gap": 0.077, "width": 0.051}), Mixture((0.0064,)), bed_height=0.09, void_fraction=0.42
    )
    solid, contacts = 1.0 - loose.void_fraction(0.09), loose.bead_coordination_number
    radius = hertz_contact_radius(PRESSURE, 200e9, 0.0064, solid, contacts)
    found = conduction(loose, STEEL, AIR, height=0.09, contact_radius=radius)
    page.add(
        "",
        f"Steel beads of 6.4 mm (42 W/m/K, 200 GPa) in air, void fraction 0.42 (porosity of the core {found.core_porosity:.3f}),",
        f"under {PRESSURE / 1e3:g} kPa, their weight at a depth of 50 mm: contacts of {radius / 0.0032:.4f} R (Hertz),",
        f"**{found.core:.2f} W/m/K** without radiation. Measured: 0.56 W/m/K (C. Beaulieu, PhD thesis, Polytechnique Montreal",
        "2020); Zehner, Bauer and Schluender with their contacts: 0.46.",
    )


if __name__ == "__main__":
    main()
