# SPDX-License-Identifier: Apache-2.0
"""What all processes share: start, stop signals, help; nodes started as processes."""
