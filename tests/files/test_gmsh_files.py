"""Scripts of gmsh's that somebody sent: none of their commands runs unless the file is trusted."""

import os

import pytest
from mpi4py import MPI

from porousmold.errors import InputError
from porousmold.files.gmsh_files import merged_files, refusal
from porousmold.mesh.from_gmsh import from_file

from ..support import MESHES

HEAD = b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n0\n$EndNodes\n$Elements\n0\n$EndElements\n"
COMMANDS = {
    "process": 'SystemCall "touch {}";',
    "process behind a text with a slash": 'a = "http://x"; SystemCall "touch {}";',
    "process behind an escaped quote": 'a = "x\\"; SystemCall "touch {}"; //";',
    "process behind mixed quotes": 'a = \' " \' // "; SystemCall "touch {}";',
    "process in the background": 'NonBlockingSystemCall "touch {}";',
    "old name": 'System "touch {}";',
    "onelab": 'OnelabRun("x", "touch {}");',
    "field": 'Field[1] = ExternalProcess; Field[1].CommandLine = "touch {}"; Background Field = 1;',
    "redirection": 'Printf("x") > "{}";',
    "redirection over lines": 'Printf("x%g",\n 1)\n >> "{}";',
    "folder": 'CreateDir "{}";',
    "save": 'Save "{}.msh";',
    "log file": 'General.LogFileName = "{}";',
    "by a setter": 'SetString("General.LogFileName", "{}");',
    "macro of a text": 'Macro("m", "SystemCall {};"); Call m;',
    "included": 'Include "other.geo";',
    "merged": 'Merge "other.msh";',
    "merged by another path": 'Merge "./other.msh";',
}


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
@pytest.mark.parametrize("name", ["mesh.geo", "mesh.msh", "mesh", "mesh.pos"])
def test_no_command_of_a_strangers_file_runs(tmp_path, monkeypatch, command, name):
    monkeypatch.chdir(tmp_path)
    trace = tmp_path / "trace"
    (tmp_path / "other.geo").write_text(f'SystemCall "touch {trace}";')
    (tmp_path / "other.msh").write_text(f'SystemCall "touch {trace}";')
    (tmp_path / name).write_text("Point(1) = {0, 0, 0};\n" + command.format(trace))
    with pytest.raises(InputError, match=r"geometry\.mesh"):
        from_file(MPI.COMM_SELF, tmp_path / name)
    assert sorted(os.listdir(tmp_path)) == sorted({name, "other.geo", "other.msh"})


def test_no_companion_of_a_mesh_is_parsed(tmp_path):
    """gmsh parses mesh.msh.opt beside mesh.msh."""
    path, trace = tmp_path / "mesh.msh", tmp_path / "trace"
    path.write_bytes(HEAD)
    (tmp_path / "mesh.msh.opt").write_text(f'SystemCall "touch {trace}";')
    with pytest.raises(InputError):
        from_file(MPI.COMM_SELF, path)
    assert not trace.exists()


def test_no_companion_of_a_merged_drawing_is_parsed(tmp_path):
    trace = tmp_path / "trace"
    for name in ("shell_mold.geo", "shell_mold.step"):
        (tmp_path / name).write_bytes((MESHES / name).read_bytes())
        (tmp_path / f"{name}.opt").write_text(f'SystemCall "touch {trace}";')
    assert from_file(MPI.COMM_SELF, tmp_path / "shell_mold.geo", dimension=3).has_wall
    assert not trace.exists()


def test_a_drawing_that_is_a_script_is_not_parsed(tmp_path):
    """A file named .step with commands in it."""
    trace = tmp_path / "trace"
    for suffix in ("step", "brep", "iges"):
        (tmp_path / f"x.{suffix}").write_text(f'SystemCall "touch {trace}";')
        (tmp_path / "mesh.geo").write_text(f'SetFactory("OpenCASCADE");\nMerge "x.{suffix}";\n')
        with pytest.raises(InputError):
            from_file(MPI.COMM_SELF, tmp_path / "mesh.geo")
    assert not trace.exists()


def test_a_trusted_script_runs(tmp_path):
    trace, path = tmp_path / "trace", tmp_path / "mesh.geo"
    path.write_text((MESHES / "mold.geo").read_text() + f'\nSystemCall "touch {trace}";\n')
    from_file(MPI.COMM_SELF, path, trusted=True)
    assert trace.exists()


def test_ordinary_scripts_pass():
    for path in MESHES.glob("*.geo"):
        assert refusal(path) is None
    assert merged_files(MESHES / "shell_mold.geo") == [MESHES / "shell_mold.step"]


def test_words_in_comments_do_not_count(tmp_path):
    path = tmp_path / "mesh.geo"
    path.write_text('// Print, Save and Merge "it"\n/* SystemCall "id"; */\nMerged = 1; Printf("x > %g", Merged);\n')
    assert refusal(path) is None


def test_the_message_names_line_and_word(tmp_path):
    path = tmp_path / "mesh.geo"
    path.write_text('// one\n/* two\nthree */\nSystemCall "id";\n')
    assert refusal(path).startswith("line 4: 'SystemCall' starts a process")
