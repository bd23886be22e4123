"""Measured runs: conversion of instrument readings to scene inputs, and comparison with a run."""
