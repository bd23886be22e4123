"""What a run gives back to Python."""

import jsonschema
import matplotlib.pyplot as plt
import numpy as np
import pytest
from mpi4py import MPI

from porousmold import run
from porousmold.output.result_keys import RESULT_KEYS, result_schema
from porousmold.solvers import newton

from ..support import coarse_scene


@pytest.fixture(scope="module")
def result():
    return run(coarse_scene(), communicator=MPI.COMM_SELF)


def test_every_key_of_the_summary_is_described(result):
    assert list(result.summary) == [name for name in RESULT_KEYS if name in result.summary]
    assert set(result.summary) == set(RESULT_KEYS) - {"checksum"}  # which stands in the file alone
    content = {**result.summary, "checksum": "0" * 64}
    jsonschema.validate(content, result_schema())
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({**content, "heating_time": "long"}, result_schema())


def test_a_result_shows_itself(result):
    assert result.warnings == result.summary["warnings"]
    assert f"{result.heating_time:.1f} s" in repr(result) and len(repr(result)) < 300
    page = result._repr_html_()
    assert f"{result.heating_time:.1f} s" in page and "data:image/png;base64," in page


def test_plot_draws_the_temperatures_into_given_axes(result):
    figure, axes = plt.subplots()
    assert result.plot(axes) is axes
    inlet = [line for line in axes.lines if np.array_equal(line.get_ydata(), result["inlet_temperature"] - 273.15)]
    assert inlet and axes.get_xlabel() == "time in min"
    plt.close(figure)


def test_history_goes_to_pandas_and_xarray_with_units(result):
    pandas, xarray = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    table, data = result.to_pandas(), result.to_xarray()
    assert isinstance(table, pandas.DataFrame) and isinstance(data, xarray.Dataset)
    assert np.array_equal(table["temperature_outer_L"], result["temperature_outer_L"])
    assert table.index.name == "time" and table.attrs["units"]["mass_flow"] == "kg/s"
    assert data["mass_flow"].attrs["units"] == "kg/s" and data["time"].attrs["units"] == "s"


def test_a_bar_is_shown_on_demand(capsys):
    run(coarse_scene({"operation.end_time": 20.0}), communicator=MPI.COMM_SELF, progress=True)
    assert "s simulated" in capsys.readouterr().err
    run(coarse_scene({"operation.end_time": 20.0}), communicator=MPI.COMM_SELF, progress=False)
    assert capsys.readouterr().err == ""


def test_a_run_leaves_no_factors_behind():
    before = len(newton._SYSTEMS)
    run(coarse_scene({"operation.end_time": 20.0}), communicator=MPI.COMM_SELF)
    assert len(newton._SYSTEMS) <= before
