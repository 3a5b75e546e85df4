# SPDX-License-Identifier: Apache-2.0
"""Memory that is settled is not looked at again, and nothing leaks by that."""

import gc
import weakref

import pytest

from spiral_gripper_ros.node.garbage import GarbageFreezer


class Loaded:
    def __init__(self):
        self.itself = self  # garbage that only a collection finds


@pytest.fixture(autouse=True)
def thaw():
    yield
    gc.unfreeze()


def test_what_is_loaded_is_looked_at_once():
    memory, loaded = GarbageFreezer(), Loaded()
    memory.freeze_for(loaded)
    settled = gc.get_freeze_count()
    assert settled > 1000
    later = [Loaded() for _ in range(10)]
    memory.freeze_for(loaded)
    assert gc.get_freeze_count() <= settled  # what is freed meanwhile counts no more
    assert len(later) == 10


def test_nothing_loaded_is_nothing_to_settle():
    memory = GarbageFreezer()
    memory.freeze_for(None)
    assert gc.get_freeze_count() == 0


def test_what_was_loaded_before_is_collected():
    memory, loaded = GarbageFreezer(), Loaded()
    memory.freeze_for(loaded)
    gone, loaded = weakref.ref(loaded), Loaded()
    memory.freeze_for(loaded)
    assert gone() is None
