"""Reads the diagnostics in a bag: what nodes refused, skipped and lost, and their latency."""

from collections import Counter
from collections import defaultdict
import contextlib
import re
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from diagnostic_msgs.msg import DiagnosticStatus
import numpy as np

from colortrack_ros.bags import BagReader
from colortrack_ros.messages.serialized import message_of_serialized
from colortrack_ros.node_kit.diagnostics import TASK

KIND = 'diagnostic_msgs/msg/DiagnosticArray'

OURS = f': {TASK}'
"""Suffix of the status names of our nodes; others are from drivers and computers."""

COUNTERS = ('refused', 'skipped', 'lost', 'repeated detections', 'skipped pairs')
"""Counters, which start at 0 whenever a node starts."""

A_COUNT = re.compile('[0-9]{1,18}')
"""What a counter is; other nodes of the same names may have published anything."""

LATENCY = 'latency from stamp, median [ms]'

Health = tuple[dict[str, float], dict[str, int]]


def health_of(reader: BagReader) -> Health:
    """Summarize the recorded diagnostics.

    :return: NODE.COUNTER, the totals; NODE.latency and NODE.latency_most, the median and the
        largest of the medians of each second [s]; and the warnings, with the number of seconds each
        was active.
    :raises MessageError: these are not diagnostics.
    """
    counts: Counter[str] = Counter()
    last: dict[str, int] = {}
    late: dict[str, list[float]] = defaultdict(list)
    said: Counter[str] = Counter()
    for node, status in _statuses(reader):
        values = {value.key: value.value for value in status.values}
        for name in COUNTERS:
            if A_COUNT.fullmatch(values.get(name, '')):
                key, now = f'{node}.{name.replace(" ", "_")}', int(values[name])
                before = last.get(key, 0)
                counts[key] += now - before if now >= before else now
                last[key] = now
        with contextlib.suppress(ValueError):  # nothing was published in this second
            late[node].append(float(values.get(LATENCY, '')) / 1e3)
        if status.level != DiagnosticStatus.OK:
            said[f'{node}: {status.message}'] += 1
    measures = {key: float(number) for key, number in counts.items()}
    for node, some in late.items():
        if some:
            measures |= {
                f'{node}.latency': float(np.median(some)),
                f'{node}.latency_most': max(some),
            }
    return dict(sorted(measures.items())), dict(said.most_common())


def _statuses(reader: BagReader) -> Any:
    """Node and status of each message, in order."""
    for topic in reader.topics:
        if topic.kind == KIND:
            for _, cdr in reader.messages(topic):
                for status in message_of_serialized(cdr, DiagnosticArray).status:
                    if status.name.endswith(OURS):
                        yield status.name.removesuffix(OURS), status
