"""Takes the transforms of TF: what tf2's TransformListener takes for a buffer."""

from collections import defaultdict
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import TransformStamped

from colortrack_ros.data import NANOSECONDS
from colortrack_ros.world.alternation import Alternation
from colortrack_ros.world.poses import WENT_BACK


class TransformIntake:
    """Passes transforms on to a buffer of tf2, and watches over them.

    :param buffer: tf2_ros.Buffer.
    :param refuse: receives the reason if transforms start anew.
    """

    def __init__(self, buffer: Any, refuse: Callable[[str], object]) -> None:
        self._buffer, self._refuse = buffer, refuse
        self._parents: dict[str, str] = {}
        self._clear()

    def set_transform(self, transform: TransformStamped, authority: str) -> None:
        """Keep a transform.

        As a simulation or bag starts again, tf2 would keep the poses of the run before, and drop
        new ones that are older than its cache.
        """
        time, child = transform.header.stamp, transform.child_frame_id
        stamp = time.sec * NANOSECONDS + time.nanosec
        if stamp < self._newest.get(child, stamp) - WENT_BACK * NANOSECONDS:
            self._buffer.clear()
            self._clear()
            self._refuse(
                f'TF: the time of {child!r} has gone back by more than {WENT_BACK:g} s: poses '
                'start anew'
            )
        self._newest[child] = max(self._newest.get(child, stamp), stamp)
        self._parents[child] = transform.header.frame_id
        t, q = transform.transform.translation, transform.transform.rotation
        self._watches[child].see(stamp, (t.x, t.y, t.z), (q.x, q.y, q.z, q.w))
        self._buffer.set_transform(transform, authority)

    def set_transform_static(self, transform: TransformStamped, authority: str) -> None:
        """Keep a static transform."""
        self._parents[transform.child_frame_id] = transform.header.frame_id
        self._buffer.set_transform_static(transform, authority)

    def rival(self, child: str, parent: str) -> str:
        """Return which frame, from a child up to its parent, two nodes publish; empty if none."""
        passed: set[str] = set()
        while child != parent and child not in passed:
            if child in self._watches and (line := self._watches[child].line):
                return (
                    f'{child!r} {line}: several nodes publish it in TF, or its poses are that noisy'
                )
            passed.add(child)
            child = self._parents.get(child, parent)
        return ''

    def _clear(self) -> None:
        self._newest: dict[str, int] = {}
        self._watches: defaultdict[str, Alternation] = defaultdict(Alternation)
