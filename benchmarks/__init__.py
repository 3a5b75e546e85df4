"""Measurements of the rod solver and the perfect wrap; ``python -m benchmarks --help``."""
