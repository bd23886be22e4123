"""A bed that a gas lifts and mixes, as a heating medium."""
