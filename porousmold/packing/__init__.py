"""Packings of beads: a small DEM generator, files of other codes, and checks."""
