"""Waiting for what has to happen."""

from collections.abc import Callable
import time

PATIENCE = 120.0
"""How long a test waits for what has to happen [s]. Only one that fails takes that long: machines
are shared, and a node that starts within a second takes 20 where ten others want the processor."""


def wait_until(
    condition: Callable[[], bool],
    seconds: float = PATIENCE,
    what: Callable[[], str] = lambda: 'condition',
) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, f'waited {seconds} s for {what()}'
        time.sleep(0.02)


def slowness() -> float:
    """How long the machine takes now for a second's work: 1 where nobody else works."""
    start, used = time.monotonic(), time.process_time()
    while time.process_time() - used < 0.2:
        pass
    return max((time.monotonic() - start) / (time.process_time() - used), 1.0)
