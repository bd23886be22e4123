"""The rotameter's conversion against the gas law, and its files."""

import numpy as np
import pytest

from porousmold.cli import main
from porousmold.experiment.rotameter import REFERENCE_PRESSURE, averaged, inlet_velocity
from porousmold.scene.series import read_series

AREA = 0.25 * np.pi * 0.1016**2
HEAD = "time [s], flow [ft^3/min], rotameter_pressure [kPa], rotameter_temperature [degC], inlet_pressure [kPa], inlet_temperature [degC]\n"  # noqa: E501


def test_at_reference_conditions_the_reading_is_the_flow():
    """9 standard cubic feet a minute through 101.6 mm are 0.524 m/s."""
    flow = 9.0 * 0.3048**3 / 60.0
    velocity = inlet_velocity(flow, REFERENCE_PRESSURE, 294.15, REFERENCE_PRESSURE, 294.15, AREA, 294.15)
    assert velocity == pytest.approx(flow / AREA, rel=1e-12) == pytest.approx(0.524, abs=1e-3)


def test_mass_is_conserved_from_the_rotameter_to_the_inlet():
    """A float in denser gas stands for Q (rho_ref/rho)^1/2; its mass flow arrives at the inlet's density."""
    flow, gas = 4e-3, 287.05
    at_float, at_inlet, reference = (REFERENCE_PRESSURE * 1.5, 300.0), (1.02e5, 340.0), 291.15
    densities = [pressure / (gas * temperature) for pressure, temperature in (at_float, at_inlet)]
    passing = flow * np.sqrt(REFERENCE_PRESSURE / (gas * reference) / densities[0])
    velocity = inlet_velocity(flow, *at_float, *at_inlet, AREA, reference)
    assert velocity * AREA * densities[1] == pytest.approx(passing * densities[0], rel=1e-12)


def test_averaging_keeps_means_and_ends():
    time = np.arange(0.0, 100.5, 0.5)
    values = 3.0 + 0.1 * time + np.where(np.arange(len(time)) % 2, 1.0, -1.0)
    there, mean = averaged(time, values, 10.0)
    assert there[0] == 0.0 and there[-1] == 100.0 and len(there) < 14
    assert mean[1:-1] == pytest.approx(3.0 + 0.1 * there[1:-1], abs=0.11)
    assert averaged(time[::20], 2.0 * time[::20], 10.0)[1] == pytest.approx(
        2.0 * time[::20]
    )  # nothing to average: as it is


def test_the_command_writes_series_for_a_scene(tmp_path, capsys):
    log = tmp_path / "log.csv"
    log.write_text(HEAD + "".join(f"{t}, 9, 101.325, 21, 101.325, {21 + t}\n" for t in range(61)))
    command = [
        "rotameter",
        str(log),
        "--diameter",
        "101.6 mm",
        "--reference-temperature",
        "21 degC",
        "--out",
        str(tmp_path),
    ]
    assert main(command) == 0
    velocity = read_series("v", tmp_path / "inlet_velocity.csv", "m/s")
    temperature = read_series("T", tmp_path / "inlet_temperature.csv", "K")
    assert velocity(0.0) == pytest.approx(0.5239, abs=2e-4)
    assert velocity(60.0) / velocity(0.0) == pytest.approx(354.15 / 294.15, rel=1e-4)
    assert temperature(30.0) == pytest.approx(324.15, abs=0.6)
    assert "written to" in capsys.readouterr().out


def test_a_reference_in_another_unit_is_refused_and_a_long_interval_is_told(tmp_path, capsys):
    log = tmp_path / "log.csv"
    log.write_text(HEAD + "".join(f"{t}, 9, 101.325, 21, 101.325, 21\n" for t in range(61)))
    command = [
        "rotameter",
        str(log),
        "--diameter",
        "101.6 mm",
        "--out",
        str(tmp_path / "out"),
        "--reference-temperature",
    ]
    assert main([*command, "21 K"]) == 2
    assert "--reference-temperature = '21 K': must be >= 200" in capsys.readouterr().err
    assert main([*command, "21 degC", "--interval", "1 h"]) == 0
    assert "longer than" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("inlet_pressure [kPa]", "pressure [kPa]", "inlet_pressure"),
        ("0, 9, 101.325", "0, 9, 3.7", "absolute"),
        ("time [s]", "t [s]", "time"),
        ("0, 9, 101.325, 21", "0, 9, 101.325, -300", "rotameter_temperature must be positive"),
        ("0, 9,", "0, -9,", "flow must be positive"),
    ],
)
def test_logs_that_cannot_be_are_refused_by_one_line(tmp_path, capsys, old, new, word):
    log = tmp_path / "log.csv"
    log.write_text((HEAD + "".join(f"{t}, 9, 101.325, 21, 101.325, 30\n" for t in range(9))).replace(old, new, 1))
    assert main(["rotameter", str(log), "--diameter", "0.1", "--reference-temperature", "294.15"]) == 2
    error = capsys.readouterr().err
    assert word in error and len(error.strip().splitlines()) == 1
