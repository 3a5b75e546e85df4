# SPDX-License-Identifier: Apache-2.0
"""Numerics that every layer shares: how kernels are compiled, where roots lie."""
