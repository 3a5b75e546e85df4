# SPDX-License-Identifier: Apache-2.0
"""What is told and drawn of a closing in true time."""
