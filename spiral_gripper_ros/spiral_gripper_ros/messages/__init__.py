# SPDX-License-Identifier: Apache-2.0
"""ROS messages from and to the values of control and planning; qualities of service."""
