"""vision_msgs/Detection2DArray -> Detections.

From the bytes, so that recordings are read where vision_msgs is not installed.
"""

from collections.abc import Callable
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import DETECTION
from colortrack_ros.data import DETECTION_BOX
from colortrack_ros.data import Detections
from colortrack_ros.messages.cdr import CdrError
from colortrack_ros.messages.cdr import Reader
from colortrack_ros.messages.errors import MessageError

BOXES = 'vision_msgs/msg/Detection2DArray'
"""Type of the messages."""

POSE = 7 + 36
"""Doubles of a PoseWithCovariance, which is in meters."""

LEAST_HYPOTHESIS = 4 + 8 * (1 + POSE)
"""Bytes of an ObjectHypothesisWithPose without a name."""

LEAST_BOX = 8 + 4 + 4 + 8 * 5 + 4
"""Bytes of a Detection2D without names and hypotheses."""

LONGEST_CLASS = 80
"""Characters of a class that are told: a line. Chosen."""

MOST_CLASSES_TOLD = 100
"""Classes of which it is told that they are left out: more than networks usually have. Chosen."""

Box = tuple[float, ...]
"""Center u, v [px], angle [rad], width and height [px], score."""


class BoxReader:
    """Turns serialized messages of boxes into Detections.

    :param classes: IDs of the classes to take, in the order of their color index; of others, each
        is told once, and left out. If empty, all are taken, as color 0.
    :param least_score: boxes with a lower one are left out, which is told once; 0 takes all, since
        some detectors' scores are negative.
    :param tell: takes a line for each class that is left out, and for low scores.
    """

    def __init__(
        self, classes: Sequence[str], least_score: float, tell: Callable[[str], object]
    ) -> None:
        self._colors = {name: color for color, name in enumerate(classes)}
        self._least, self._has_told_scores = least_score, False
        self._tell = tell
        self._told: set[str] = set()

    def read(self, cdr: bytes) -> Detections:
        """The detections of a message: its boxes, without covariance.

        A box has the class and score of its most likely hypothesis; one without any has no class
        and score 1. Of a box that is turned, it is the upright box around that. Its area is that
        of an ellipse which touches all sides: the locator takes what is round for a ball.

        :raises MessageError: these are not the bytes of such a message.
        """
        try:
            reader = Reader(cdr)
            stamp, frame_id = reader.header()
            boxes, colors = [], []
            for _ in range(reader.count(LEAST_BOX)):
                name, box = _next_box(reader)
                color = self._colors.get(name) if self._colors else 0
                if color is None:
                    self._leave_out(name)
                    continue
                if self._least and box[-1] < self._least:
                    self._leave_out_unlikely()
                    continue
                boxes.append(box)
                colors.append(color)
            reader.end()
        except CdrError as error:
            raise MessageError(f'not a serialized {BOXES}: {error}') from error
        rows = _rows_of(boxes)
        rows['color'] = colors
        return Detections(rows, stamp, frame_id)

    def _leave_out(self, name: str) -> None:
        name = name[:LONGEST_CLASS]
        if name not in self._told and len(self._told) < MOST_CLASSES_TOLD:
            self._told.add(name)
            self._tell(f'class {name!r} is left out: expected one of {list(self._colors)}')

    def _leave_out_unlikely(self) -> None:
        if not self._has_told_scores:
            self._has_told_scores = True
            self._tell(f'boxes with scores below {self._least:g} are left out, see min_box_score')


def _next_box(reader: Reader) -> tuple[str, Box]:
    """The class of the next vision_msgs/Detection2D, and its box."""
    reader.header()
    name, score = '', 1.0
    for nth in range(reader.count(LEAST_HYPOTHESIS)):
        other, (likely, *_) = reader.string(), reader.doubles(1 + POSE)
        if nth == 0 or likely > score:
            name, score = other, likely
    box = reader.doubles(5)
    reader.string()
    return name, (*box, score)


def _rows_of(boxes: Sequence[Box]) -> NDArray[np.void]:
    """The detections, (N,) of DETECTION."""
    rows = np.zeros(len(boxes), DETECTION)
    u, v, theta, width, height, score = np.reshape(boxes, (-1, 6)).T
    with np.errstate(over='ignore', invalid='ignore'):  # the tracker refuses what is not finite
        cos, sin = np.abs(np.cos(theta)), np.abs(np.sin(theta))
        size = np.stack([cos * width + sin * height, sin * width + cos * height], axis=1)
        corners = rows.view(DETECTION_BOX)
        corners['size'], corners['corner'] = size, np.stack([u, v], axis=1) - (size - 1) / 2
        rows['u'], rows['v'], rows['score'] = u, v, score
        rows['area'] = np.pi / 4 * width * height
    return rows
