"""Beads sheared between two walls: what their motion and their contacts conduct."""
