"""Porosity against wall distance: models of the literature and tabulated profiles."""
