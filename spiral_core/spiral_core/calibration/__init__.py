# SPDX-License-Identifier: Apache-2.0
"""The calibration: from bench readings to constants, with their uncertainty."""
