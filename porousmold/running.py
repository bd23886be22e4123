"""One run from scene to result: march, warn, sum up, write."""

import platform
import time as clock
from dataclasses import dataclass, field

import dolfinx
import numpy as np
import petsc4py
from mpi4py import MPI

from . import __version__
from .accuracy import scenes_to_run
from .checkpoint import fingerprint
from .energy_use import energy_use
from .errors import InputError, SolveError
from .results import RunFolder
from .scene import SMALLEST_RATIO
from .simulation import Simulation, temperature_bounds
from .solvers.flow import silent

HIGHEST_MACH_NUMBER = 0.3
HIGHEST_BIOT_NUMBER = 0.1
LARGEST_OVERSHOOT = 0.1
LARGEST_UNDERSHOOT = 0.05
FAILED = "failed"
SOONEST_SAVING, SAVING_PART = 1.0, 0.02
"""Seconds between two checkpoints at least, and the part of the time that they may take: a run that is killed loses little."""
ROOM, FIELDS_KEPT = 10 * 2**20, 120
"""Bytes on the disk, and copies of all unknowns, that a run's files may need: snapshots, fields, a checkpoint and the next."""


@dataclass
class Result:
    """What a run gives: `summary` is the content of result.json, `history` arrays by name with `units` by name."""

    summary: dict
    history: dict[str, np.ndarray]
    units: dict[str, str]
    failure: SolveError | None = field(default=None)

    @property
    def heating_time(self):
        """Heating time of the whole wall, s; None if not reached."""
        return self.summary["heating_time"]


class RunInterrupted(Exception):  # noqa: N818 - as KeyboardInterrupt, no error
    """The user stopped the run; what was computed is written."""


def run(scene, out=None, communicator=None, progress=None, stop=lambda: False, resume=False, observe=None):
    """Run a scene on a communicator (default: all ranks; collective) and give its `Result`.

    out: folder to write, or None to write nothing. progress: called as progress(time, deficit, simulation) after every
    step; observe: called as observe(text) with what is being done between steps. stop: called at every iteration; where it
    is true the run ends with `RunInterrupted`, its results written as of the last step. resume:
    go on from the checkpoint in `out`, if there is one; a run that is done there is given as it stands. Raises `InputError`
    before anything is written, and `SolveError` after what was computed has been written.
    """
    communicator = communicator or MPI.COMM_WORLD
    if out is None:
        return _Run(scene, None, communicator, progress, stop, observe).result()
    folder = RunFolder(out, communicator, kept=resume)
    try:
        done = folder.finished(scene) if resume else None
        if done is not None:
            summary, columns, units = done
            return Result(summary, {name: np.array(values) for name, values in columns.items()}, units)
        saved = folder.saved() if resume else None
        return _Run(scene, folder, communicator, progress, stop, observe, saved).result()
    finally:
        folder.close()


class _Run:
    """The marches of one run: a single one, or those that `solver.accuracy` asks for.

    `outcomes` holds what came of the earlier marches: a heating time (s), None, or `FAILED`.
    """

    def __init__(self, scene, folder, communicator, progress, stop, observe, saved=None):
        self._start = clock.perf_counter()
        self._observe = observe or silent
        self._scene, self._folder, self._communicator, self._stop = scene, folder, communicator, stop
        self._progress = progress
        self._scenes = scenes_to_run(scene)
        self._outcomes: list = []
        self._heating_time_error = None
        # the marches that an accuracy asks for must be alike
        self._mark = fingerprint(scene, going_on=scene.solver.accuracy is None)
        first, memory = next(self._scenes), None
        if saved is not None:
            given, memory = saved
            if given != self._mark:
                raise InputError(
                    "--resume", str(folder.path), "holds a checkpoint of another scene, or program version"
                )
            for outcome in memory.outcomes:
                first = self._after(outcome)
        self._simulation = Simulation(first, communicator, self._observe)
        if memory is not None:
            memory.restore(self._simulation)
        self._due = clock.perf_counter() + min(scene.output.checkpoint_interval, SOONEST_SAVING)
        if folder is not None:
            folder.require(ROOM + FIELDS_KEPT * 8 * sum(self._simulation.problem.unknowns.values()))

    def _after(self, outcome):
        """The scene to march next; raises `StopIteration` after the last, and `SolveError` if a failure ends it all."""
        self._outcomes.append(outcome)
        return self._scenes.throw(SolveError("", 0.0, "", "")) if outcome == FAILED else self._scenes.send(outcome)

    def result(self):
        """March to the end, write everything, and give the `Result`."""
        failure = interruption = None
        while True:
            try:
                self._simulation.march(self._after_step, self._stop)
                outcome = self._simulation.heating_time
            except SolveError as error:
                failure, outcome = error, FAILED
            except KeyboardInterrupt as error:
                interruption = error
                self._stop()  # a rank that was told by another one sees its own signal
                break
            try:
                following = self._after(outcome)
            except StopIteration as end:
                self._heating_time_error = end.value
                break
            except SolveError:
                self._outcomes.pop()
                break
            failure = None
            self._simulation = Simulation(following, self._communicator, self._observe)
        summary = self._write(failure, interruption)
        simulation = self._simulation
        result = Result(
            summary,
            {name: np.array(values) for name, values in simulation.history.columns.items()},
            simulation.history.units,
            failure,
        )
        if failure is not None:
            raise failure
        if interruption is not None:
            raise RunInterrupted(f"stopped at t = {simulation.time:.6g} s") from interruption
        return result

    def _after_step(self, time, deficit):
        if self._folder is not None and self._communicator.bcast(clock.perf_counter() >= self._due):
            begun = clock.perf_counter()
            self._folder.save(self._simulation, self._outcomes, self._mark)
            now = clock.perf_counter()
            worth = max(SOONEST_SAVING, (now - begun) / SAVING_PART)
            self._due = now + min(self._scene.output.checkpoint_interval, worth)
        if self._progress:
            self._progress(time, deficit, self._simulation)

    def _write(self, failure, interruption):
        """Everything that the folder is to hold; gives the summary."""
        scene, simulation, folder = self._scene, self._simulation, self._folder
        error = self._heating_time_error
        summary = summarise(simulation, error, failure, interrupted=interruption is not None)
        summary["fingerprint"] = fingerprint(scene)
        if error is not None and error > scene.solver.accuracy:
            summary["warnings"].append(f"the estimated error {error:.2g} exceeds the accuracy asked for")
        if scene.solver.accuracy is None and FAILED in self._outcomes:
            cells = simulation.scene.solver.mesh_refinement
            summary["warnings"].append(
                f"a solve failed on the scene's own cells; this is with mesh_refinement {cells:g}"
            )
        unfinished = (failure or interruption) is not None
        with simulation.problem.stopwatch("output"):
            if folder is not None and simulation.history.columns:
                if unfinished:
                    folder.save(simulation, self._outcomes, self._mark)
                folder.write_data(simulation)
        summary["wall_seconds"] = {"total": clock.perf_counter() - self._start} | simulation.problem.stopwatch.seconds
        if folder is not None:
            folder.write_summary(summary, simulation.scene)
            if not unfinished:
                folder.forget_checkpoint()
        return summary


def summarise(simulation, heating_time_error=None, failure=None, interrupted=False):
    """The content of result.json (a collective call), all but the seconds."""
    history, balance, scene = simulation.history, simulation.problem.heat.balance, simulation.scene
    flow, heat = simulation.problem.flow, simulation.problem.heat
    recorded = bool(history.columns)
    lows, highs = (history.columns.get(name, []) for name in ("lowest_temperature", "highest_temperature"))
    bounds = [min(lows), max(highs)] if recorded else None
    used = dict.fromkeys(("fluid_heat", "pumping_work", "energy_spent", "mean_power"))
    if recorded:
        used = energy_use(history, simulation.problem.laws.fluid, scene.operation, simulation.heating_time)
    return {
        "status": "failed" if failure else "interrupted" if interrupted else "done",
        "failure": str(failure) if failure else None,
        "heating_time": simulation.heating_time,
        "heating_time_error": heating_time_error,
        "heating_time_bed_side": simulation.heating_time_bed_side,
        "end_time": simulation.time,
        "mass_flow_initial": history["mass_flow"][0] if recorded else None,
        "mass_flow_final": history["mass_flow"][-1] if recorded else None,
        "mass_imbalance": simulation.problem.mass_imbalance if recorded else None,
        "energy_imbalance": balance.imbalance,
        "energy_rev_residual": balance.by_rev_terms / balance.by_fluid if balance.by_fluid else 0.0,
        "heat_by_fluid": balance.by_fluid,
        "heat_stored": balance.stored,
        **used,
        "temperature_bounds": bounds,
        "time_steps": len(history["time"]) - 1 if recorded else 0,
        "rejected_steps": simulation.control.rejected,
        "repeated_steps": heat.repetitions,
        "flow_regimes": simulation.regimes,
        "flow_solves": flow.solves,
        "continuation_steps": flow.continuation_steps,
        "newton_iterations": {"flow": flow.newton_iterations, "energy": heat.newton_iterations},
        "unknowns": simulation.problem.unknowns,
        "bead_biot_number": simulation.problem.estimates.bead_biot_number,
        "bead_reynolds_number": simulation.problem.estimates.reynolds_number,
        "model": scene.as_tables()["model"],
        "sources": simulation.problem.laws.sources(scene, simulation.problem.has_wall),
        "versions": {
            "porousmold": __version__,
            "dolfinx": dolfinx.__version__,
            "petsc4py": petsc4py.__version__,
            "numpy": np.__version__,
            "python": platform.python_version(),
            "ranks": simulation.problem.communicator.size,
        },
        "warnings": warnings_of(simulation, bounds),
    }


def warnings_of(simulation, bounds):
    """Everything the reader of the result should know: limits of the model that this run touched (collective)."""
    scene, estimates = simulation.scene, simulation.problem.estimates
    operation = scene.operation
    found = []
    if simulation.heating_time is None and simulation.time >= operation.end_time * (1 - 1e-9):
        found.append(
            f"not heated to within {operation.heating_margin:g} K by operation.end_time {operation.end_time:g} s"
        )
    if estimates.bead_biot_number > HIGHEST_BIOT_NUMBER and scene.model.bead_modes is None:
        found.append(
            f"bead Biot number {estimates.bead_biot_number:.2g} > {HIGHEST_BIOT_NUMBER}: "
            "beads are taken as isothermal, which they are not (see model.bead_modes)"
        )
    low, high = simulation.problem.laws.nusselt.reynolds_range
    if not low <= estimates.reynolds_number <= high:
        found.append(
            f"bead Reynolds number {estimates.reynolds_number:.3g} is outside {low:g} to {high:g}, "
            f"the range of model.nusselt {scene.model.nusselt!r}"
        )
    if bounds is not None:
        mach = simulation.problem.highest_mach_number()
        if mach > HIGHEST_MACH_NUMBER:
            found.append(
                f"Mach number {mach:.2g} > {HIGHEST_MACH_NUMBER}: the energy balance is that of low Mach numbers"
            )
        for owner, law_name, law in simulation.problem.laws.properties(simulation.problem.has_wall):
            first, last = law.temperature_range
            if bounds[0] < first or bounds[1] > last:
                found.append(
                    f"{owner} {law_name} is given for {first:g} to {last:g} K, used for {bounds[0]:.4g} to {bounds[1]:.4g} K"
                )
        lowest, highest = temperature_bounds(operation)
        beyond = max(lowest - bounds[0], bounds[1] - highest)
        if beyond > LARGEST_OVERSHOOT:
            found.append(
                f"temperatures reached {beyond:.2g} K beyond those given, behind the sharp first front: "
                "more solver.axial_cells lessen it"
            )
    undershoot = simulation.problem.flow.largest_undershoot
    if undershoot > LARGEST_UNDERSHOOT:
        found.append(f"k undershoots by {undershoot:.0%} of its largest value in single cells, where it counts as 0")
    if len(simulation.regimes) > 1:
        found.append(
            "with these settings a laminar flow is steady, too; this is the turbulent one (flow_regimes), as if tripped"
        )
    if scene.model.flow == "plug" and scene.model.turbulence != "none":
        found.append("plug flow carries no turbulence: model.turbulence has no effect")
    geometry = scene.geometry
    walled = geometry.width if geometry.sides == "wall" else None
    width = min((w for w in (geometry.cavity_height, walled, geometry.diameter) if w), default=None)
    if width is not None and width < SMALLEST_RATIO * scene.bed.bead_diameter * (1.0 - 1e-9):
        found.append(
            f"the bed is {width / scene.bed.bead_diameter:.1f} beads wide, below {SMALLEST_RATIO:g}: "
            "averages over a packing lose their meaning there"
        )
    return found
