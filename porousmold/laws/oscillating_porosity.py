r"""Void fraction of thin shells along a wall (the oscillating profile), as measured in the literature.

de Klerk, AIChE Journal 49 (2003) 2022-2029, a fit to measurements of several authors, with z = y/d:

    phi = 2.14 z^2 - 2.53 z + 1                                                        for z <= 0.637
    phi = phi_b + 0.29 exp(-0.6 z) cos(2.3 pi (z - 0.16)) + 0.15 exp(-0.9 z)           for z > 0.637

quoted as the literature on packed beds repeats it; the paper itself was not at hand. The two branches meet for
phi_b = 0.36.
"""

import numpy as np

from ..arrays import Floats
from .functions import Value


def de_klerk(position: Value, bulk_porosity: Value) -> Floats:
    """Void fraction at wall distances `position` >= 0 (in bead diameters; array), far from the wall bulk_porosity."""
    z = np.asarray(position, float)
    inner = 2.14 * z**2 - 2.53 * z + 1.0
    outer = bulk_porosity + 0.29 * np.exp(-0.6 * z) * np.cos(2.3 * np.pi * (z - 0.16)) + 0.15 * np.exp(-0.9 * z)
    return np.where(z <= 0.637, inner, outer)
