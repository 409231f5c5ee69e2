"""The tracker's work per frame, counted, so that neither load nor machine matters."""

import dis
from functools import cache
from pathlib import Path
import sys
from types import CodeType
from types import FrameType
from typing import Any

import numpy as np
import pytest

import colortrack_ros
from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.tracking.tracker import Tracker

WORK = ('BINARY_', 'INPLACE_', 'UNARY_', 'COMPARE_', 'CALL', 'STORE_SUBSCR', 'STORE_SLICE')
"""Prefixes of bytecodes that call something, or may operate on an array."""

MOST = 1026
"""Most of them in an uneventful frame: 1023 with Python 3.11, a few more with 3.13. It keeps work
from being added unnoticed; it does not tell how long each takes."""


PACKAGE = str(Path(colortrack_ros.__file__).parent)
"""Not the clone around it, which may be a folder of the same name, as in a colcon workspace."""


@cache
def works(code: CodeType) -> frozenset[int]:
    """Return the offsets of such bytecodes."""
    return frozenset(i.offset for i in dis.get_instructions(code) if i.opname.startswith(WORK))


def count_work(call: Any) -> int:
    """Return how many such bytecodes of the package are run."""
    count = 0

    def trace(frame: FrameType, event: str, _: object) -> Any:
        nonlocal count
        if not frame.f_code.co_filename.startswith(PACKAGE):
            return None
        frame.f_trace_opcodes, frame.f_trace_lines = True, False
        count += event == 'opcode' and frame.f_lasti in works(frame.f_code)
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        call()
    finally:
        sys.settrace(before)
    return count


def far_apart(count: int, k: int) -> Detections:
    """Return objects with boxes, each on its own line, as seen in frame k."""
    rows, noise = np.zeros(count, DETECTION), np.random.default_rng(k).normal(0, 0.5, (2, count))
    rows['u'], rows['v'] = 60 + 2.0 * k + noise[0], 40.0 * (1 + np.arange(count)) + noise[1]
    rows['cov_uu'] = rows['cov_vv'] = 0.25
    rows['box_w'] = rows['box_h'] = 20
    rows['box_u'], rows['box_v'], rows['area'] = rows['u'] - 10, rows['v'] - 10, 300
    return Detections(rows, round(k * 1e9 / 30), image_size=(640, 640))


@pytest.mark.parametrize('count', [1, 10])
def test_a_frame_in_which_nothing_happens_takes_so_many_steps(count):
    tracker = Tracker()
    for k in range(60):
        tracker.update(far_apart(count, k))
    steps = [count_work(lambda k=k: tracker.update(far_apart(count, k))) for k in range(60, 75)]
    assert len(tracker.update(far_apart(count, 75)).rows) == count
    assert np.median(steps) <= MOST
