# SPDX-License-Identifier: Apache-2.0
"""Conversion of ROS messages from and to the values of control and planning; QoS profiles."""
