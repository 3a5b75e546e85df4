# SPDX-License-Identifier: Apache-2.0
"""The design: from objects and limits to tube, angles, length and pressures."""
