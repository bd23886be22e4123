"""Going on from a checkpoint: the same answer as without the interruption."""

import json

import h5py
import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI

from porousmold import InputError, Scene, run
from porousmold.files.atomic_files import locked
from porousmold.mesh import fenicsx
from porousmold.output.checkpoint import NAME, NodeOrder, read
from porousmold.output.folder import RunFolder
from porousmold.scene.identity import identity_of
from porousmold.simulation.running import RunInterrupted

from ..support import ALUMINIUM, COARSE, STUDIES, box, coarse_scene, under_mpirun

LAMINAR = {"model.turbulence": "none"}


def stopped_after(steps):
    """`progress` and `stop` for `run` that let so many steps pass."""
    left = list(range(steps))
    return {"progress": lambda *_: left and left.pop(), "stop": lambda: not left}


def interrupted(scene, out, steps):
    with pytest.raises(RunInterrupted):
        run(scene, out, MPI.COMM_SELF, **stopped_after(steps))
    assert (out / NAME).is_file()


def assert_same(one, other, tolerance):
    assert one.heating_time == pytest.approx(other.heating_time, rel=tolerance)
    assert one.summary["energy_imbalance"] == pytest.approx(other.summary["energy_imbalance"], abs=tolerance)
    assert one.summary["time_steps"] == other.summary["time_steps"]
    for name in one.history:
        size = np.max(np.abs(other.history[name])) + 1e-300
        assert one.history[name] / size == pytest.approx(other.history[name] / size, abs=tolerance), name


@pytest.mark.parametrize("changes", [
    {}, {"flow": "developed"}, {"flow": "plug", "flow_update": "frozen"}, {"flow_update": "transient"},
    {"energy": "one-temperature", "wall": "thin"}, {"bead_modes": 2},
], ids=lambda changes: ",".join(map(str, changes.values())) or "default")  # fmt: skip
def test_an_interrupted_run_comes_to_the_same_answer(changes, tmp_path):
    chosen = {f"model.{name}": value for name, value in changes.items()}
    scene = coarse_scene({"output.pictures": False, "operation.heating_margin": 50.0, **chosen})
    whole = run(scene, communicator=MPI.COMM_SELF)
    interrupted(scene, tmp_path, 5)
    assert_same(run(scene, tmp_path, MPI.COMM_SELF, resume=True), whole, 1e-10)
    assert not (tmp_path / NAME).exists()


def test_with_an_inlet_that_changes_and_steps_that_adapt(tmp_path):
    inlet = tmp_path / "inlet.csv"
    inlet.write_text("time [s], temperature [degC]\n0, 25\n60, 90\n300, 60\n360, 90\n")
    scene = coarse_scene(
        {
            "operation.inlet_temperature": str(inlet),
            "operation.end_time": 700.0,
            "solver.step_tolerance": 0.02,
            **LAMINAR,
        }
    )
    whole = run(scene, communicator=MPI.COMM_SELF)
    assert whole.summary["rejected_steps"] > 0
    for steps in (4, 9, 14):
        with pytest.raises(RunInterrupted):
            run(scene, tmp_path / "run", MPI.COMM_SELF, resume=True, **stopped_after(steps))
    assert_same(run(scene, tmp_path / "run", MPI.COMM_SELF, resume=True), whole, 1e-10)


def test_between_the_integrations_that_accuracy_asks_for(tmp_path):
    scene = coarse_scene({"solver.accuracy": 0.1, "operation.heating_margin": 50.0, **LAMINAR})
    whole = run(scene, communicator=MPI.COMM_SELF)
    first_integrate = run(scene.changed({"solver.accuracy": None, "solver.mesh_refinement": 0.5, "solver.step_refinement": 0.5}),
                      communicator=MPI.COMM_SELF)  # fmt: skip
    interrupted(scene, tmp_path, first_integrate.summary["time_steps"] + 3)
    again = run(scene, tmp_path, MPI.COMM_SELF, resume=True)
    assert again.heating_time == pytest.approx(whole.heating_time, rel=1e-10)
    assert again.summary["heating_time_error"] == pytest.approx(whole.summary["heating_time_error"], rel=1e-8)


def test_a_run_that_is_done_is_given_as_it_stands(tmp_path):
    scene = coarse_scene({"operation.heating_margin": 60.0, **LAMINAR})
    first = run(scene, tmp_path, MPI.COMM_SELF)
    before = (tmp_path / "result.json").stat().st_mtime_ns
    assert_same(run(scene, tmp_path, MPI.COMM_SELF, resume=True), first, 1e-15)
    assert (tmp_path / "result.json").stat().st_mtime_ns == before


def test_another_run_s_results_do_not_stay_where_nothing_is_gone_on_from(tmp_path):
    run(coarse_scene({"operation.end_time": 5.0, **LAMINAR}), tmp_path, MPI.COMM_SELF)
    other = coarse_scene({"operation.end_time": 6.0, "output.fields": False, **LAMINAR})
    run(other, tmp_path, MPI.COMM_SELF, resume=True, force=True)
    assert json.loads((tmp_path / "result.json").read_text())["end_time"] == pytest.approx(6.0)
    assert not (tmp_path / "fields.xdmf").exists()
    for content in ("[]", "{", '{"status": "done"}'):
        (tmp_path / "result.json").write_text(content)
        assert run(other, tmp_path, MPI.COMM_SELF, resume=True, force=True).summary["end_time"] == pytest.approx(6.0)
    (tmp_path / "history.csv").unlink()
    assert run(other, tmp_path, MPI.COMM_SELF, resume=True).summary["time_steps"] > 0


def test_a_file_that_changes_during_the_run_does_not_make_its_result_that_of_the_new_one(tmp_path):
    profile = tmp_path / "profile.csv"
    original = (STUDIES / "profiles" / "cylinder_ratio_20.csv").read_text()
    profile.write_text(original)
    scene = coarse_scene({"bed.porosity_profile": str(profile), **LAMINAR})
    before = identity_of(scene)
    profile.write_text(original + "\n")
    assert identity_of(scene) == before
    assert identity_of(scene.changed({})) != before


def test_a_longer_end_time_may_be_asked_for_but_no_other_scene(tmp_path):
    scene = coarse_scene(LAMINAR)
    interrupted(scene, tmp_path, 3)
    with pytest.raises(InputError, match="another scene"):
        run(scene.changed({"wall.thickness": "2 mm"}), tmp_path, MPI.COMM_SELF, resume=True)
    longer = run(scene.changed({"operation.end_time": 20.0}), tmp_path, MPI.COMM_SELF, resume=True)
    assert longer.resumed_at == longer["time"][3] > 0.0
    assert longer.summary["end_time"] == pytest.approx(20.0)


def test_damaged_checkpoints_and_busy_folders_are_refused_by_one_line(tmp_path):
    scene = coarse_scene(LAMINAR)
    (tmp_path / NAME).write_bytes(b"no checkpoint")
    with pytest.raises(InputError, match="is damaged"):
        run(scene, tmp_path, MPI.COMM_SELF, resume=True)
    with h5py.File(tmp_path / NAME, "w") as file:
        file.attrs["identity"] = "x"
    with pytest.raises(InputError, match="is damaged"):
        run(scene, tmp_path, MPI.COMM_SELF, resume=True)
    lock = locked(tmp_path / ".lock")
    with pytest.raises(InputError, match="another process"):
        run(scene, tmp_path, MPI.COMM_SELF)
    lock.close()


@pytest.mark.mpi
def test_the_order_of_nodes_does_not_depend_on_the_partition():
    """What one rank stores, every number of ranks reads back at the same places."""
    wholes, locals_ = [], []
    for communicator in (MPI.COMM_SELF, MPI.COMM_WORLD):
        domain = box((7, 5), wall=0.2, communicator=communicator)
        scalar, vector = (fenicsx.lagrange_element(domain.mesh, 1, components) for components in (1, 2))
        for space in (
            fenicsx.mixed_space(domain.mesh, [vector, scalar, scalar]),
            fenicsx.lagrange_space(domain.mesh, 1, 2),
            fenicsx.cell_constant_space(domain.mesh),
        ):
            function = fem.Function(space)
            parts = range(space.num_sub_spaces) if space.dofmap.index_map_bs == 1 and space.num_sub_spaces else [None]
            for part in parts:
                target = function if part is None else function.sub(part)
                size = target.function_space.dofmap.bs if part is None else (2 if part == 0 else 1)
                rows = [1.0 + (part or 0), -2.0][:size]
                target.interpolate(
                    lambda x, rows=rows: np.array([f * x[0] + x[1] ** 2 for f in rows])[: len(rows)].squeeze()
                )
            function.x.scatter_forward()
            order = NodeOrder(space)
            wholes.append(communicator.bcast(order.gather(function.x.array)))
            assert order.scatter(wholes[-1]) == pytest.approx(function.x.array, abs=1e-15)
            locals_.append(function)
    for alone, together in zip(wholes[:3], wholes[3:], strict=True):
        assert together == pytest.approx(alone, abs=1e-14)


def test_mass_balance_of_a_resumed_run_is_that_of_the_flow_it_stands_at(tmp_path):
    """Stopped, and stopped again before another step: what flows in is what the flow was solved for, half a step ago."""
    ramp = tmp_path / "ramp.csv"
    ramp.write_text("time [s], mass flow [kg/s]\n0, 0.01\n200, 0.04\n")
    scene = coarse_scene(
        {"operation.mass_flow": str(ramp), "operation.pressure_drop": None, "model.turbulence": "none"}
    )
    for steps in (8, 0):
        with pytest.raises(RunInterrupted):
            run(scene, tmp_path / "run", MPI.COMM_SELF, resume=True, **stopped_after(steps))
        summary = json.loads((tmp_path / "run" / "result.json").read_text())
        assert summary["time_steps"] == 8 and 20.0 < summary["end_time"] < 200.0
        assert abs(summary["mass_imbalance"]) < 1e-5


def test_on_another_number_of_ranks_after_kills(tmp_path):
    """1, then 2, then 3 ranks, each killed in the middle, with an inlet that changes and steps that adapt to it: the answer of
    an uninterrupted run on one rank."""
    inlet = tmp_path / "inlet.csv"
    inlet.write_text("time [s], temperature [degC]\n0, 25\n60, 90\n300, 60\n360, 90\n")
    changes = COARSE | {"operation.heating_margin": "40 K", "output.checkpoint_interval": 0, "output.pictures": False,
                        "operation.inlet_temperature": str(inlet), "solver.step_tolerance": 0.01,
                        "model.bead_modes": 1, "model.turbulence": "none"}  # fmt: skip
    scene = Scene.load(ALUMINIUM, changes)
    whole = run(scene, communicator=MPI.COMM_SELF)
    assert whole.summary["rejected_steps"] > 0
    code = (
        "import os, sys\nfrom porousmold import Scene, run\nimport porousmold.scene\n"
        "steps = int(sys.argv[1])\ncount = 0\n"
        "def progress(*_):\n    global count\n    count += 1\n    if count == steps:\n        os._exit(1)\n"
        f"run(Scene.load({str(ALUMINIUM)!r}, {changes!r}), {str(tmp_path / 'run')!r}, progress=progress, resume=True)\n"
    )
    for ranks, steps in ((1, 6), (2, 7), (3, 8), (1, 1000)):
        ended = under_mpirun(ranks, "-c", code, str(steps))
        assert (ended.returncode == 0) == (steps == 1000), ended.stderr
    found = json.loads((tmp_path / "run" / "result.json").read_text())
    assert found["heating_time"] == pytest.approx(whole.heating_time, rel=1e-8)
    assert found["energy_imbalance"] == pytest.approx(whole.summary["energy_imbalance"], abs=1e-8)
    assert found["time_steps"] == whole.summary["time_steps"]


def test_a_flipped_bit_is_refused(tmp_path):
    """Wherever it is: among numbers it would go on from another state to another answer."""
    scene = coarse_scene({"output.pictures": False, "operation.heating_margin": 50.0, **LAMINAR})
    interrupted(scene, tmp_path, 5)
    sound = (tmp_path / NAME).read_bytes()
    for place in np.random.default_rng(1).integers(0, len(sound), 200):
        content = bytearray(sound)
        content[place] ^= 1 << int(place) % 8
        (tmp_path / NAME).write_bytes(content)
        with pytest.raises(InputError, match="is damaged"):
            read(tmp_path / NAME, MPI.COMM_SELF)
    for content in (b"", sound[:-1], sound[:40], sound + b"0"):
        (tmp_path / NAME).write_bytes(content)
        with pytest.raises(InputError, match="is damaged"):
            run(scene, tmp_path, MPI.COMM_SELF, resume=True)
    (tmp_path / NAME).write_bytes(sound)
    assert run(scene, tmp_path, MPI.COMM_SELF, resume=True).heating_time is not None


@pytest.mark.parametrize("name", ["result.json", "history.csv"])
def test_a_table_with_another_digit_is_not_taken_for_the_result(tmp_path, name):
    scene = coarse_scene({"operation.end_time": 20.0, "output.pictures": False})
    run(scene, tmp_path, MPI.COMM_SELF)
    assert run(scene, tmp_path, MPI.COMM_SELF).recalled
    text = (tmp_path / name).read_text()
    place = next(i for i in range(len(text) // 2, len(text)) if text[i] in "12345678")
    (tmp_path / name).write_text(text[:place] + str(int(text[place]) + 1) + text[place + 1 :])
    with pytest.raises(InputError, match="are not what was written: --force"):
        run(scene, tmp_path, MPI.COMM_SELF)
    assert not run(scene, tmp_path, MPI.COMM_SELF, force=True).recalled


def test_pictures_of_every_kind_go_with_the_run_that_they_were_drawn_of(tmp_path):
    """Those of `show --format svg` stayed beside the next run's results."""
    scene = coarse_scene({"operation.end_time": 5.0, "output.pictures": False})
    run(scene, tmp_path, MPI.COMM_SELF)
    for name in ("temperatures.svg", "skin.pdf", "heating.gif", "notes.txt"):
        (tmp_path / name).write_text("of the run before")
    run(scene, tmp_path, MPI.COMM_SELF, force=True)
    assert {path.suffix for path in tmp_path.iterdir()} & {".svg", ".pdf", ".gif", ".txt"} == {".txt"}


def test_two_hundred_flipped_bits_give_no_other_result(tmp_path):
    """Of the checkpoint and of the tables: refused, computed again, or of no meaning."""
    scene = coarse_scene({"operation.end_time": 20.0, "output.pictures": False, "output.checkpoint_interval": 0.0})
    with pytest.raises(RunInterrupted):
        run(scene, tmp_path / "stopped", MPI.COMM_SELF, **stopped_after(2))
    run(scene, tmp_path / "done", MPI.COMM_SELF)
    identity, draw = identity_of(scene), np.random.default_rng(7)
    whole = (RunFolder(tmp_path / "done", MPI.COMM_SELF, kept=True)).finished(identity)
    assert whole is not None
    for name in (NAME, "result.json", "history.csv"):
        path = tmp_path / ("stopped" if name == NAME else "done") / name
        content = path.read_bytes()
        for _ in range(100 if name == NAME else 50):
            place = int(draw.integers(len(content)))
            flipped = bytes([content[place] ^ (1 << int(draw.integers(8)))])
            path.write_bytes(content[:place] + flipped + content[place + 1 :])
            if name == NAME:
                with pytest.raises(InputError):
                    read(path, MPI.COMM_SELF)
                continue
            folder = RunFolder(tmp_path / "done", MPI.COMM_SELF, kept=True)
            try:
                found = folder.finished(identity)
            except InputError:
                found = None
            folder.close()
            assert found is None or found[0] == whole[0]
        path.write_bytes(content)
