# SPDX-License-Identifier: Apache-2.0
"""Closing on an object in real time: filling, lag, contact on the way, and what then holds."""
