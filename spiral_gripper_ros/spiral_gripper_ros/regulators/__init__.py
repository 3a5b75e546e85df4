# SPDX-License-Identifier: Apache-2.0
"""The adapter from ``pressure_command`` to common pressure regulators."""
