"""What a run gives back to Python: the summary, the recorded columns, and ways to look at them."""

import base64
import html
import importlib
import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..output.quantities import Columns, Recorded, quantity
from ..output.result_keys import Summary

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes


@dataclass(repr=False)
class Result:
    """What a run gives: `summary` is the content of result.json, `history` the recorded columns as arrays with a `unit`;
    `recalled` tells that it was done before and stood in the folder, `resumed_at` from which time (s) on it was computed where it
    went on from a checkpoint."""

    summary: Summary
    history: dict[str, Recorded]
    recalled: bool = False
    resumed_at: float | None = None

    @classmethod
    def of(
        cls, summary: Summary, columns: Columns, *, recalled: bool = False, resumed_at: float | None = None
    ) -> "Result":
        """Of a summary and the history's columns."""
        return cls(summary, {name: Recorded.of(name, columns[name]) for name in columns}, recalled, resumed_at)

    def __getitem__(self, name: str) -> Recorded:
        """A column of the history, for example result["temperature_outer_L"]; its `unit` is that of its values."""
        return self.history[name]

    @property
    def heating_time(self) -> float | None:
        """Heating time of the whole wall, s; None if not reached."""
        return self.summary["heating_time"]

    @property
    def warnings(self) -> list[str]:
        """What the run says of its own numbers, a sentence each."""
        return list(self.summary["warnings"])

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw the temperatures against time into axes of matplotlib, new ones by default; gives the axes."""
        from ..output.figures import plt
        from ..output.pictures import draw_temperatures, marks_of

        if axes is None:
            _, axes = plt.subplots(figsize=(9.5, 5.0), layout="constrained")
        draw_temperatures(axes, self.history, marks_of(self.summary))
        return axes

    def to_pandas(self) -> "pandas.DataFrame":
        """The history as a table over the time (s); `attrs["units"]` has the unit of every column. Needs pandas."""
        pandas = _optional("pandas")
        columns = {name: np.array(values) for name, values in self.history.items()}
        table = pandas.DataFrame(columns).set_index("time")
        table.attrs["units"] = {name: values.unit for name, values in self.history.items()}
        return table

    def to_xarray(self) -> "xarray.Dataset":
        """The history as a data set over the time (s), with units and words as attributes. Needs xarray."""
        xarray = _optional("xarray")

        def described(name: str) -> dict[str, str]:
            return {"units": self.history[name].unit, "long_name": quantity(name).label}

        columns = {name: ("time", np.array(values), described(name)) for name, values in self.history.items()}
        return xarray.Dataset(columns)

    def __repr__(self) -> str:
        what = ", ".join(f"{name} {value}" for name, value in self._main().items())
        return f"<Result: {what}>"

    def _repr_html_(self) -> str:
        """A table of the main results and the picture of the temperatures, for notebooks."""
        rows = "".join(f"<tr><th>{html.escape(n)}</th><td>{html.escape(v)}</td></tr>" for n, v in self._main().items())
        warnings = "".join(f"<li>{html.escape(text)}</li>" for text in self.warnings)
        return f"<table>{rows}</table><ul>{warnings}</ul>{self._picture()}"

    def _main(self) -> Mapping[str, str]:
        summary = self.summary
        time, error = summary["heating_time"], summary["heating_time_error"]
        found = {"status": summary["status"]}
        if time is not None or summary["has_heating_time"]:
            found["heating time"] = f"{time:.1f} s" if time is not None else "not reached"
        if error is not None:
            found["numerical error"] = f"{error:.2%}"
        found |= {f"target {name}": f"{met:.1f} s" if met else "not met" for name, met in summary["targets"].items()}
        if summary["mass_flow_final"] is not None:
            found["mass flow"] = f"{summary['mass_flow_final']:.4g} kg/s"
        found["relative heat imbalance"] = f"{summary['energy_imbalance']:.1e}"
        return found | {"warnings": str(len(summary["warnings"]))}

    def _picture(self) -> str:
        if len(self.history.get("time", ())) < 2:
            return ""
        from ..output.figures import plt

        figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
        self.plot(axes)
        content = io.BytesIO()
        figure.savefig(content, format="png", dpi=80)
        plt.close(figure)
        data = base64.b64encode(content.getvalue()).decode()
        return f'<img alt="temperatures against time" src="data:image/png;base64,{data}">'


def _optional(name: str) -> Any:
    """A package that a run does without. Raises `ImportError` that names Debian's package where it is missing."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        raise ImportError(f"needs {name}: apt install python3-{name}") from None
