# SPDX-License-Identifier: Apache-2.0
"""The doctor: is everything there, and does it fit together?"""
