"""The folder of compiled forms: another one where the user's cannot be written, and what is pruned."""

import fcntl
import os
import subprocess
import sys
import time

import pytest

from porousmold.cli import main
from porousmold.files.cache_folder import Contents, contents, prune


@pytest.fixture
def folder(tmp_path):
    """Two compiled forms, one of them not used for two days, and one that is being compiled."""
    folder = tmp_path / "fenics" / "porousmold"
    folder.mkdir(parents=True)
    for name in ("libffcx_old", "libffcx_new", "libffcx_begun"):
        for ending, text in ((".c", "text"), (".o", "object"), (".c.cached", ""), (".so", "library"), (".lock", "")):
            if name != "libffcx_begun" or ending in (".c", ".lock"):
                (folder / f"{name}{ending}").write_text(text)
    os.utime(folder / "libffcx_old.c.cached", (time.time() - 2 * 86400.0,) * 2)
    return folder


def test_what_is_not_used_is_pruned_and_of_the_rest_what_nobody_reads(folder):
    assert contents(folder) == Contents(2, 2 * 17 + 4, 2 * 10)
    assert prune(folder, 86400.0) == Contents(1, 7 + 4, 0)
    assert not (folder / "libffcx_old.so").exists()
    assert (folder / "libffcx_new.so").read_text() == "library" and (folder / "libffcx_new.c").read_text() == ""
    assert (folder / "libffcx_begun.c").read_text() == "text"


def test_what_another_process_compiles_is_left_alone(folder):
    with (folder / "libffcx_old.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        assert prune(folder, 86400.0).forms == 2


def test_the_command_shows_and_prunes(folder, monkeypatch, capsys):
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder.parent.parent))
    assert main(["cache"]) == 0
    assert "2 compiled forms" in capsys.readouterr().out
    assert main(["cache", "--prune", "1 day"]) == 0
    assert "left: 1 compiled forms" in capsys.readouterr().out
    assert main(["cache", "--prune", "-1 day"]) == 2


@pytest.mark.parametrize("home", ["/dev/null", "/dev/null/nobody", "~"])
def test_a_cache_that_cannot_be_written_is_replaced(home, tmp_path):
    script = "import os; from porousmold.files.cache_folder import replacing_cache; print(replacing_cache(), replacing_cache())"
    environment = {**os.environ, "HOME": home, "TMPDIR": str(tmp_path)}
    environment.pop("XDG_CACHE_HOME", None)
    told = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    folder = tmp_path / f"porousmold-{os.getuid()}"
    assert told.stdout.split() == [str(folder), "None"] and folder.stat().st_mode & 0o077 == 0
    folder.chmod(0o777)  # anybody could have put a library there
    told = subprocess.run([sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True)
    other = told.stdout.split()[0]
    assert other.startswith(f"{tmp_path}/porousmold-") and other != str(folder)
