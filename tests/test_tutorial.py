"""The tutorial's scene and its answer."""

import re
import tomllib
from pathlib import Path

import pytest
from mpi4py import MPI

from porousmold import Scene, run

PAGE = (Path(__file__).parent.parent / "docs" / "tutorials" / "own-mold.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_tutorials_mold_takes_as_long_as_it_says():
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    told = float(re.search(r"inlet\): ([\d.]+) s", PAGE).group(1))
    scene = Scene(tomllib.loads(text))
    assert run(scene, communicator=MPI.COMM_SELF).heating_time == pytest.approx(told, rel=1e-3)
