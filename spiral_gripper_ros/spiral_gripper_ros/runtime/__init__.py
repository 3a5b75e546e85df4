# SPDX-License-Identifier: Apache-2.0
"""What services, actions, display and diagnosis share of a running gripper."""
