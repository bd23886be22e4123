"""BibTeX of the sources of a run."""

import json

import pytest

from porousmold.cli import main
from porousmold.laws.material_library import FLUIDS, SOLIDS
from porousmold.output.citation import citations


def of(tmp_path, sources):
    content = {"versions": {"porousmold": "9.9"}, "sources": sources, "materials": {}}
    (tmp_path / "result.json").write_text(json.dumps(content))
    return citations(tmp_path)


def test_a_source_becomes_an_article(tmp_path):
    text = of(tmp_path, {"nusselt": "Wakao, Kaguei, Funazkri, Chem. Eng. Sci. 34 (1979) 325-336"})
    assert "% nusselt\n@article{wakao1979," in text and "author = {Wakao and Kaguei and Funazkri}" in text
    assert "journal = {Chem. Eng. Sci.}" in text and "pages = {325-336}" in text
    assert "version = {9.9}" in text and "Granular Beds for Injection Molding" in text


def test_several_sources_of_one_law_are_entries_of_their_own(tmp_path):
    text = of(
        tmp_path,
        {"turbulence": "Launder, Spalding 1974; Chen, Patel 1988; thesis eq. 7.33", "drag": "Chen, Patel 1988"},
    )
    assert text.count("@misc{") == 2 and "% turbulence, drag" in text and "7.33" not in text
    assert "others" in of(tmp_path, {"drag": "Macdonald et al., Ind. Eng. Chem. Fundam. 18 (1979) 199-208"})


def test_keys_are_unique_and_braces_closed_for_all_materials(tmp_path):
    sources = {
        f"{name} {what}": law.source
        for library in (FLUIDS, SOLIDS) for name in library for what, law in library[name].laws().items()
    }  # fmt: skip
    text = of(tmp_path, sources)
    keys = [line.split("{")[1] for line in text.splitlines() if line.startswith("@")]
    assert len(keys) == len(set(keys)) > 5 and text.count("{") == text.count("}")


@pytest.mark.parametrize("content", [None, "[]", '{"versions": 3}'])
def test_what_is_no_run_is_refused(tmp_path, capsys, content):
    if content is not None:
        (tmp_path / "result.json").write_text(content)
    assert main(["cite", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1
