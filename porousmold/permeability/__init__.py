"""Permeability of a bed by the falling-head test: theory, measured data, and how well it can be measured."""
