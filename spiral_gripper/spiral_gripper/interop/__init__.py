# SPDX-License-Identifier: Apache-2.0
"""Our solvers behind the interfaces of other projects."""
