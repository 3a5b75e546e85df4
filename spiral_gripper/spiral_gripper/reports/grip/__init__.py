# SPDX-License-Identifier: Apache-2.0
"""Reports and plots of a closing in real time."""
