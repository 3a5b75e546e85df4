# SPDX-License-Identifier: Apache-2.0
"""Garbage collection that does not hold up the control loop."""

from __future__ import annotations

import gc


class GarbageFreezer:
    """Keeps the garbage collector away from what stays.

    A full collection looks at every object of the process. Most belong to the libraries and to
    the loaded gripper and stay as long as it does: looking at them takes 50 to 150 ms, in which
    nothing is commanded. After :meth:`freeze_for` collections take microseconds.
    """

    def __init__(self) -> None:
        self._frozen_for: object = None

    def freeze_for(self, loaded: object) -> None:
        """Collect everything once, and leave alone what is left from then on.

        Does so only when ``loaded`` is another object than the last time, and not None.

        Args:
            loaded: what has been loaded last, such as a gripper.
        """
        if loaded is None or loaded is self._frozen_for:
            return
        self._frozen_for = loaded
        gc.unfreeze()
        gc.collect()
        gc.freeze()
