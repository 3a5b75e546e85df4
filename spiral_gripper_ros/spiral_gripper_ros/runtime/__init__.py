# SPDX-License-Identifier: Apache-2.0
"""The running gripper, which services, actions, display and diagnosis share."""
