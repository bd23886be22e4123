"""What the user writes: keys, series in time, sensors, and the checked scene. No dolfinx."""
