# SPDX-License-Identifier: Apache-2.0
"""Adapters of the solvers to the interfaces of other projects."""
