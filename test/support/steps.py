"""Steps of work, counted, so that neither load nor machine matters."""

import dis
from functools import cache
from pathlib import Path
import sys
from types import CodeType
from types import FrameType
from typing import Any

import colortrack_ros

WORK = ('BINARY_', 'INPLACE_', 'UNARY_', 'COMPARE_', 'CALL', 'STORE_SUBSCR', 'STORE_SLICE')
"""Prefixes of bytecodes that call something, or may operate on an array."""

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
