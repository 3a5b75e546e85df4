# SPDX-License-Identifier: Apache-2.0
"""A rod held at both ends, against obstacles with friction: certified static equilibria."""
