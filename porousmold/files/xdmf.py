"""fields.xdmf: the XML beside fields.h5 that ParaView, meshio and the pictures read.

dolfinx writes a collection over time for every field. Readers take the first collection for all there is, so the fields of a time
are put into one grid: Domain / Grid (collection over time) / Grid (Time, Topology, Geometry, one Attribute a field).
"""

import copy
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..arrays import Floats


def one_grid_a_time(path: Path) -> None:
    """Rewrite the XML that dolfinx wrote so that each time is one grid with all its fields."""
    tree = ElementTree.parse(path)
    domain = tree.getroot().find("Domain")
    assert domain is not None
    mesh = next(grid for grid in domain if grid.find("Topology") is not None)
    fields: dict[str, list[Any]] = {}
    for grid in domain.iter("Grid"):
        time = grid.find("Time")
        if time is not None:
            fields.setdefault(time.attrib["Value"], []).extend(grid.findall("Attribute"))
    for grid in list(domain):
        domain.remove(grid)
    steps = ElementTree.SubElement(domain, "Grid", Name="fields", GridType="Collection", CollectionType="Temporal")
    for time_value, attributes in sorted(fields.items(), key=lambda item: float(item[0])):
        step = ElementTree.SubElement(steps, "Grid", Name="fields", GridType="Uniform")
        ElementTree.SubElement(step, "Time", Value=time_value)
        step.extend([copy.deepcopy(part) for part in mesh if part.tag in ("Topology", "Geometry")])
        step.extend(attributes)
    ElementTree.indent(tree)
    tree.write(path, encoding="utf-8", xml_declaration=True)


def read_fields(path: Path) -> tuple[Any, ...]:
    """Nodes (n, 2 or 3) in m, cells (rows of node numbers in drawing order) and {time: {name: values}} of fields.xdmf: values at
    the nodes, of `region` in the cells."""
    root = ElementTree.parse(path).getroot()
    with h5py.File(Path(path).with_suffix(".h5"), "r") as file:

        def data(element: Any) -> Any:
            return file[element.findtext("DataItem").strip().split(":", 1)[1]][()]

        nodes = data(next(root.iter("Geometry")))
        cells = data(next(root.iter("Topology")))
        steps: dict[float, dict[str, Floats]] = {}
        for grid in root.iter("Grid"):
            time = grid.find("Time")
            if time is not None:
                steps[float(time.attrib["Value"])] = {
                    attribute.attrib["Name"]: data(attribute).squeeze() for attribute in grid.iter("Attribute")
                }
    flat = nodes.shape[1] == 2 or np.ptp(nodes[:, 2]) == 0.0
    return nodes[:, :2] if flat else nodes, cells, steps
