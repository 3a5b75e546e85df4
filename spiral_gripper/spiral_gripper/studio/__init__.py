# SPDX-License-Identifier: Apache-2.0
"""The studio: a gripper in three dimensions, in the browser."""
