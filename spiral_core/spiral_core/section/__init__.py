# SPDX-License-Identifier: Apache-2.0
"""The bent section of a wound tube: strains around it, from the fibers' constraints alone."""
