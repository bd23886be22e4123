"""The one module that knows dolfinx's versions."""

from porousmold import fenicsx


def test_a_killed_compilation_is_forgotten_but_not_that_of_a_living_process(tmp_path):
    alone, shared = tmp_path / "alone", tmp_path / "shared"
    for cache in (alone, shared):
        cache.mkdir()
        for name in ("begun.c", "ready.c", "ready.c.cached"):
            (cache / name).touch()
    other_process = fenicsx.hold.__wrapped__(shared)
    (shared / "begun.c").touch()
    locks = [fenicsx.hold(cache) for cache in (alone, shared)]
    assert not (alone / "begun.c").exists()
    assert (alone / "ready.c").exists()
    assert (shared / "begun.c").exists()
    for lock in (other_process, *locks):
        lock.close()
