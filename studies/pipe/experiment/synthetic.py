"""Writes a SYNTHETIC experiment: logger, heat loss and measured temperatures, all computed and made noisy; nothing is measured.

The logger's and the heat flux sensors' readings are made up; the temperatures are those of the program's own expensive model (all
time derivatives, every unknown coupled) at the sensors, with noise. Real data would take the places of the three synthetic files.
Run: python studies/pipe/experiment/synthetic.py (minutes)
"""

from pathlib import Path

import numpy as np

from porousmold import Scene, run
from porousmold.cli import main as command_line

HERE = Path(__file__).parent
NOISE = 0.3
"""K, standard deviation of every temperature that is told."""
DURATION = 2400.0
NOTE = "# synthetic, by synthetic.py: nothing measured\n"
EXPENSIVE = {"model.flow_update": "transient", "output.fields": False, "output.pictures": False}


def write(name, head, rows):
    """A CSV file that says what it is."""
    text = "".join(", ".join(f"{value:.7g}" for value in row) + "\n" for row in rows)
    (HERE / name).write_text(f"{NOTE}{head}\n{text}", encoding="utf-8")


def main():
    """Write all files."""
    random = np.random.default_rng(62710)
    time = np.arange(0.0, DURATION + 1.0, 5.0)
    warmed = 1.0 - np.exp(-time / 150.0)
    steady = random.normal(0.0, 1.0, (3, len(time)))
    write("log_synthetic.csv", "time [s], flow [ft^3/min], rotameter_pressure [kPa], rotameter_temperature [degC], "
          "inlet_pressure [kPa], inlet_temperature [degC]", np.column_stack([
              time, 9.0 + 0.02 * steady[0], 105.0 + 0.05 * steady[1], np.full(len(time), 22.0), 101.6 + 0.01 * steady[2],
              23.0 + 37.0 * warmed]))  # fmt: skip
    slowly = np.arange(0.0, DURATION + 1.0, 240.0)
    losses = [[-80.0 * (1.0 - np.exp(-t / (600.0 + 2000.0 * z))) for z in (0.125, 0.25, 0.375, 0.5)] for t in slowly]
    write("heat_loss_synthetic.csv", "time [s], 0.125 m [W/m^2], 0.25 m [W/m^2], 0.375 m [W/m^2], 0.5 m [W/m^2]",
          np.column_stack([slowly, losses]))  # fmt: skip
    command_line(["rotameter", str(HERE / "log_synthetic.csv"), "--diameter", "101.6 mm",
                  "--reference-temperature", "21 degC", "--interval", "120 s", "--out", str(HERE)])  # fmt: skip
    truth = run(Scene.load(HERE / "experiment.toml", EXPENSIVE))
    sensors = [name for name in truth.history if name.startswith("sensor_")]
    told = np.arange(30.0, DURATION, 30.0)
    columns = [np.interp(told, truth.history["time"], truth.history[name]) - 273.15 for name in sensors]
    noisy = [column + random.normal(0.0, NOISE, len(told)) for column in columns]
    head = "time [s], " + ", ".join(f"{name.removeprefix('sensor_')} [degC]" for name in sensors)
    write("measured_synthetic.csv", head, np.column_stack([told, *noisy]))


if __name__ == "__main__":
    main()
