"""Options of PETSc: ours are defaults, those that a user gives win.

A user gives them in the environment, as PETSC_OPTIONS="-porousmold_flow_snes_monitor". They are global: two systems of one
process that need different values have different prefixes.
"""

from collections.abc import Mapping

from petsc4py import PETSc


def set_defaults(prefix: str, values: Mapping[str, object]) -> None:
    """Set options, by their names without the prefix, that are not set yet."""
    options = PETSc.Options()
    for name, value in values.items():
        if not options.hasName(prefix + name):
            options[prefix + name] = value


def given(prefix: str, but_for: Mapping[str, object]) -> bool:
    """Whether any option with the prefix is set to other than the values of `but_for`."""
    ours = {prefix + name: str(value) for name, value in but_for.items()}
    options = PETSc.Options().getAll()
    return any(name.startswith(prefix) and ours.get(name) != value for name, value in options.items())
