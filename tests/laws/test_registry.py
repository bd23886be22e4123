"""Laws by name, of the package and from elsewhere."""

from importlib.metadata import EntryPoint

import pytest

from porousmold.errors import InputError
from porousmold.laws import registry
from porousmold.laws.drag import DRAG_LAWS
from porousmold.laws.registry import Registry, source_text


def test_laws_stand_in_the_order_of_their_registration():
    laws = Registry("test")
    laws.register("b", 1)
    laws.register("a", 2)
    assert list(laws) == ["b", "a"] and laws["a"] == 2 and len(laws) == 2
    assert DRAG_LAWS.is_own("ergun") and not laws.is_own("a")
    with pytest.raises(InputError, match="name"):
        laws.register(" a", 3)


def test_installed_packages_bring_their_laws(tmp_path, monkeypatch):
    """A module named as an entry point is imported; one that fails is named in one line."""
    (tmp_path / "their_laws.py").write_text("import porousmold.laws.registry as r\nr.Registry('x').register('y', 1)\n")
    monkeypatch.syspath_prepend(tmp_path)
    given = [EntryPoint("theirs", "their_laws", registry.ENTRY_POINTS)]
    monkeypatch.setattr(registry, "entry_points", lambda group: given if group == registry.ENTRY_POINTS else [])
    registry.load_entry_points.__wrapped__()
    given.append(EntryPoint("broken", "no_such_module", registry.ENTRY_POINTS))
    with pytest.raises(InputError, match="broken"):
        registry.load_entry_points.__wrapped__()


def test_source_text_tells_laws_apart_by_what_they_compute():
    def one(x):
        return 2.0 * x

    def other(x):
        return 3.0 * x

    assert source_text(one) == source_text(one) != source_text(other)
    at_a_prompt = [eval(compile(f"lambda x: x * {factor}", "<prompt>", "eval")) for factor in (2.0, 2.0, 3.0)]
    assert source_text(at_a_prompt[0]) == source_text(at_a_prompt[1]) != source_text(at_a_prompt[2])
