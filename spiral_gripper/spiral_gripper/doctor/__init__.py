# SPDX-License-Identifier: Apache-2.0
"""The command ``doctor``: checks of the installation and of gripper files."""
