"""ufl and ffcx, imported without `pkg_resources`: those of Debian 12 ask it for their own version alone, which takes a tenth of a
second of every command. Import this before anything that imports dolfinx."""

import sys
from importlib.metadata import version
from types import ModuleType, SimpleNamespace

_versions = ModuleType("pkg_resources")
_versions.__dict__["get_distribution"] = lambda name: SimpleNamespace(version=version(name))
_is_there = sys.modules.setdefault("pkg_resources", _versions) is not _versions
try:
    import ffcx
    import ufl
finally:
    if not _is_there:  # who wants more of it gets the real one
        del sys.modules["pkg_resources"]

__all__ = ["ffcx", "ufl"]
