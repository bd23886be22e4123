"""Empirical laws and properties: small pure functions of floats, arrays or UFL, each with its equation, range and source."""
