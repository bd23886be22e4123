"""Settings of all tests."""

from hypothesis import settings

# a busy machine is no failure; pytest's own time-out guards against what never ends
settings.register_profile("porousmold", deadline=None)
settings.load_profile("porousmold")
