# SPDX-License-Identifier: Apache-2.0
"""From radius and gravity to wraps and shapes, without ROS."""
