# SPDX-License-Identifier: Apache-2.0
"""Programs beside the node: commands for a running node, the demo, the simulation."""
