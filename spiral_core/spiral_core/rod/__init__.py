# SPDX-License-Identifier: Apache-2.0
"""The rod: certified static shapes under load. Knows no actuator."""
