"""Names for what MPI and dolfinx do not type."""

from typing import Any, TypeAlias

Communicator: TypeAlias = Any
"""An MPI communicator."""
Constant: TypeAlias = Any
"""A dolfinx constant: its `value` can be set."""
Expression: TypeAlias = Any
"""A UFL expression or form."""
Mesh: TypeAlias = Any
"""A dolfinx mesh."""
Space: TypeAlias = Any
"""A dolfinx function space."""
GmshModel: TypeAlias = Any
"""A module `gmsh.model`, with a mesh in it."""
Form: TypeAlias = Any
"""A compiled dolfinx form."""
