# SPDX-License-Identifier: Apache-2.0
"""Measurements of the rod solver and the perfect wrap; ``python -m benchmarks --help``."""
