# SPDX-License-Identifier: Apache-2.0
"""The frame of every process: start, stop signals, help; a node as a process of its own."""
