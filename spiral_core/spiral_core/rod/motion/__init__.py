# SPDX-License-Identifier: Apache-2.0
"""The rod in time: inertia, damping, and contact as in the static solver."""
