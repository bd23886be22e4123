"""Meshes of bed and wall, dolfinx and what differs between its versions, values at points."""
