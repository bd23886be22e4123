"""`studies/stores/schumann.toml` by OpenTerrace 0.1.4 (PyPI), run by the Python of its own environment: `make peers`.

Reads a store as JSON from standard input, writes times, temperatures of the fluid and CPU seconds as JSON to standard output.
Beads are lumped, the fluid has no conduction. Its steps are explicit: 0.9 of the longest for which no temperature oscillates.
"""

import json
import sys
import time

import numpy as np
from openterrace import Simulate
from openterrace.convection_schemes.upwind_1d import upwind_1d

ROWS = 400
"""Of the output, about."""


def main() -> None:
    """Run the store that was given."""
    store = json.load(sys.stdin)
    cells, radius, porosity = store["cells"], 0.5 * store["bead_diameter"], store["porosity"]
    fluid, beads = store["fluid"], store["beads"]
    held = porosity * fluid["rho"] * 0.25 * np.pi * store["diameter"] ** 2  # kg of fluid per metre
    last_cell = 0.5 * store["length"] / (cells - 1)  # half of the others
    exchange = 6.0 * (1.0 - porosity) / store["bead_diameter"] * store["coefficient"]
    step = 0.9 / (store["mass_flow"] / (held * last_cell) + exchange / (porosity * fluid["rho"] * fluid["cp"]))

    simulation = Simulate(t_end=store["end_time"], dt=step)
    gas = simulation.create_phase(n=cells, type="fluid")
    gas.select_substance_on_the_fly(**fluid)
    gas.select_domain_shape(domain="cylinder_1d", D=store["diameter"], H=store["length"])
    gas.select_porosity(phi=porosity)
    gas.select_schemes(conv="upwind_1d")
    gas.select_initial_conditions(T=store["initial_temperature"])
    gas.select_massflow(mdot=store["mass_flow"])
    first, last = ((slice(None), place) for place in (0, -1))
    gas.select_bc(bc_type="fixed_value", parameter="T", position=first, value=store["inlet_temperature"])
    gas.select_bc(bc_type="zero_gradient", parameter="T", position=last)
    steps = np.arange(0.0, store["end_time"] + step, step)
    gas.select_output(times=steps[:: max(len(steps) // ROWS, 1)])
    stones = simulation.create_phase(n=1, n_other=cells, type="bed")
    stones.select_substance_on_the_fly(**beads)
    stones.select_domain_shape(domain="lumped", A=4.0 * np.pi * radius**2, V=4.0 / 3.0 * np.pi * radius**3)
    stones.select_initial_conditions(T=store["initial_temperature"])
    simulation.select_coupling(fluid_phase=0, bed_phase=1, h_exp="constant", h_value=store["coefficient"])

    upwind_1d(np.zeros((1, 3)), np.zeros((2, 1, 3)))  # compiles it
    begun = time.process_time()
    simulation.run_simulation()
    found = {
        "seconds": time.process_time() - begun,
        "steps": len(steps),
        "time": gas.data.time.tolist(),
        "outlet": gas.data.T[:, 0, -1].tolist(),
        "middle": [float(np.interp(0.5 * store["length"], gas.node_pos, row[0])) for row in gas.data.T],
    }
    json.dump(found, sys.stdout)


if __name__ == "__main__":
    main()
