"""Forms that are compiled side by side, each in a process of its own."""

import contextlib
import functools
import os
from functools import partial
from pathlib import Path

from ..files.subprocesses import forked
from . import fenicsx
from .aliases import Expression, Form


class DeferredForm:
    """A UFL form that is compiled while others are: its compilation begins at once, in a process of its own, and is waited for
    where `form` is first asked for. Forms that were compiled before are only loaded then."""

    def __init__(self, form: Expression) -> None:
        self._ufl_form = form
        self._child = _begin_to_compile(form) if form.ufl_domain().ufl_cargo().comm.size == 1 else None
        _PENDING.append(self)

    @functools.cached_property
    def form(self) -> Form:
        """The compiled form (collective)."""
        if self._child is not None:
            with contextlib.suppress(ChildProcessError):
                os.waitpid(self._child, 0)
        compiled = fenicsx.compiled_form(self._ufl_form)
        if self._child is not None:
            _known(self._ufl_form).touch()
        return compiled


_PENDING: list[DeferredForm] = []
"""Forms begun since the last `finish_compiling`."""


def finish_compiling() -> None:
    """Wait for every form that was begun (collective)."""
    while _PENDING:
        _ = _PENDING.pop(0).form


def _known(form: Expression) -> Path:
    """File that is there if a form of this signature was compiled once."""
    known = Path(fenicsx.compiler_options()["cache_dir"]) / "known"
    known.mkdir(exist_ok=True)
    return known / fenicsx.signature_of(form)


def _begin_to_compile(form: Expression) -> int | None:
    """Number of a process that compiles the form into the cache; None where it stands there."""
    if _known(form).exists():
        return None
    return forked(partial(fenicsx.compiled_form, form))
