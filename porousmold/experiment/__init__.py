"""Measured runs: what the instruments told, made ready for a scene, and compared with what the scene gave."""
