"""What the pages say is run: every `sh` and `python` block of README, tutorials and notebooks, in the order of the page.

Blocks run in a copy of the shipped scenes. A `toml` or `python` block that begins with a comment of a file's name is that file.
Left out are blocks marked `console` (installation) and `text` (what was printed).
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from porousmold.output.result_keys import reference

ROOT = Path(__file__).parents[1]
PAGES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs" / "tutorials").glob("*.md")),
    ROOT / "docs" / "command-line.md",
    ROOT / "docs" / "moving-beads.md",
    ROOT / "docs" / "droplet.md",
]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
BLOCK = re.compile(r"^```(sh|python|toml|console|text)\n(.*?)^```$", re.DOTALL | re.MULTILINE)


def blocks_of(page):
    """(language, text) of the blocks of a page."""
    return BLOCK.findall(page.read_text(encoding="utf-8"))


@pytest.fixture
def workplace(tmp_path):
    """A folder with the shipped scenes and meshes, and no runs."""
    for name in ("studies", "meshes"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


@pytest.mark.docs
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_block_of_a_page_runs(page, workplace):
    outside = {name: value for name, value in os.environ.items() if not name.startswith(("OMPI_", "PMIX_"))}
    environment = {**outside, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}", "OMP_NUM_THREADS": "1"}
    ran = 0
    for language, text in blocks_of(page):
        named = re.match(r"# (\w+\.(?:py|toml))\n", text)
        if named:
            (workplace / named[1]).write_text(text, encoding="utf-8")
            continue
        command = {"sh": ["bash", "-ec", text], "python": [sys.executable, "-c", text]}.get(language)
        if command is None:
            continue
        done = subprocess.run(command, cwd=workplace, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{text}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
        ran += 1
    assert ran > 0


@pytest.mark.docs
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run(notebook, workplace):
    import nbformat
    from nbclient import NotebookClient

    folder = workplace / "docs" / "notebooks"
    folder.mkdir(parents=True)
    os.environ["PATH"] = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    client = NotebookClient(nbformat.read(notebook, 4), timeout=300, resources={"metadata": {"path": str(folder)}})
    client.km = client.create_kernel_manager()
    client.km.kernel_spec.argv[0] = sys.executable  # this environment's Python
    # sockets in a folder: a free port is chosen before it is taken, and another kernel may be faster
    client.km.transport, client.km.ip = "ipc", str(workplace / "kernel")
    client.execute()
    shown = [output for cell in client.nb.cells for output in cell.get("outputs", [])]
    assert any("image/png" in output.get("data", {}) for output in shown)


def test_pages_name_files_that_exist():
    """Links between pages and to pictures."""
    for page in [*PAGES, *(ROOT / "docs").glob("*.md")]:
        for target in re.findall(r"\]\(([^)#]+?)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            assert "://" in target or (page.parent / target).exists(), f"{page.name}: {target}"


def test_the_page_of_a_results_keys_is_what_the_program_prints():
    assert (ROOT / "docs" / "result.md").read_text(encoding="utf-8") == reference(), (
        "porousmold keys --result > docs/result.md"
    )


def test_readme_is_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 120
