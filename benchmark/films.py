"""Films of objects of known colors with their truth: scenes, and three videos of a tossed ball."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.scenes import open_scene
from colortrack_ros.scenes.scene import TRUTH

VIDEOS = Path(__file__).parents[2] / 'shared' / 'data' / 'ball_toss'
GREEN = (50.0, -60.0, 22.0)
TOSSED = {
    'ball': (61.8, 22, [(17, 36)]),
    'ball2': (57.0, 26, [(28, 462), (488, 787), (825, 962)]),
    'ball4': (60.0, 50, [(117, 437)]),
}
"""The tolerance around GREEN that was chosen for each video by hand, the ball's radius [px], and
the frames that show it; test/detection/test_ball_toss.py compares with positions read by eye."""


class SceneFilm:
    """A scene with its truth."""

    def __init__(self, spec: str) -> None:
        self._scene = open_scene(spec)
        self.colors = list(self._scene.colors)
        self.parts = [range(len(self._scene))] * 3

    def frame(self, k: int) -> Frame:
        """Render a frame."""
        return Frame(self._scene.render(k), stamp=round(k * NANOSECONDS / self._scene.rate))

    def truth(self, k: int) -> NDArray[np.void]:
        """The balls of a frame."""
        return self._scene.truth(k)


class TossedFilm:
    """The three videos of a ball one after the other; truth is what the chosen color finds."""

    colors = ('ball',)

    def __init__(self, folder: Path) -> None:
        self._pictures: list[NDArray[np.uint8]] = []
        self._truth: list[NDArray[np.void]] = []
        self.parts: list[range] = []
        for name in TOSSED:
            first = len(self._pictures)
            self._read(folder, name)
            self.parts.append(range(first, len(self._pictures)))

    def _read(self, folder: Path, name: str) -> None:
        tolerance, radius, stretches = TOSSED[name]
        color = ReferenceColor('ball', GREEN, tolerance)
        detector = Detector(DetectorConfig(colors=(color,), min_area=150, closing_size=9))
        video = cv2.VideoCapture(str(folder / f'{name}.mp4'))
        number = 0
        while video.grab():
            shown = any(first <= number <= last for first, last in stretches)
            if name == 'ball' or number % 5 == 0:
                picture = video.retrieve()[1]
                rows = detector.detect(Frame(picture)).rows[: int(shown)]
                truth = np.zeros(len(rows), TRUTH)
                truth['u'], truth['v'], truth['radius'] = rows['u'], rows['v'], radius
                truth['visible'] = 1
                if len(rows) or not shown:
                    self._pictures.append(picture)
                    self._truth.append(truth)
            number += 1

    def frame(self, k: int) -> Frame:
        """A frame of one of the videos."""
        return Frame(self._pictures[k], stamp=k * NANOSECONDS)

    def truth(self, k: int) -> NDArray[np.void]:
        """The ball in a frame, if it is there."""
        return self._truth[k]
