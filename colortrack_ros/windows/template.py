"""What a target looks like, and where exactly a window looks like it."""

from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Picture = NDArray

STEPS = 2
"""Steps of Gauss and Newton towards the place of a window."""

STRIDE = 1.0
"""Longest of them [px]."""

PATIENCE = 3
"""Matches in a row that a change of look has to last, unless it is a turn or a change of size."""

EXPLAINED = 0.6
"""Then the similarity falls by no more than this share of what the likeness falls by."""


PROVED = 12
"""Valid matches after which a template shows the target and nothing that was about to cover it."""


class Region:
    """A part of a picture.

    :param gray: (H, W) gray levels, float32.
    :param corner: u, v of its top left pixel [px].
    """

    def __init__(self, gray: Picture, corner: NDArray[np.intp]) -> None:
        self.gray, self.corner = gray, corner

    def window(self, center: Floats, shape: tuple[int, ...]) -> Picture:
        """The window (height, width) around a center with a fraction of a pixel.

        What would be outside repeats the region's border.

        :param center: (u, v) [px].
        :param shape: height and width [px].
        """
        u, v = (center - self.corner).tolist()
        return cv2.getRectSubPix(self.gray, shape[::-1], (u, v))


class Template:
    """The look of a target.

    :param picture: (h, w) gray levels, float32, both odd.
    :param last: the template before this one.
    """

    def __init__(self, picture: Picture, last: 'Template | None' = None) -> None:
        self.picture = picture
        self.matches = 0
        """Valid matches so far."""
        self.former: Template | None = last
        """The last one that had proved itself, for when this one is not found."""
        if last is not None and last.matches < PROVED:
            self.former = last.former
        if self.former is not None:
            self.former.former = None
        self.fresh = (0.0, 0.0)
        """Similarity and likeness of the first match since the picture was taken, 0 until then."""
        self._worn = 0

    def wears(self, similarity: float, likeness: float, renewal: float) -> bool:
        """Take note of a valid match; return whether it should be the next template.

        :param renewal: see WindowConfig.
        """
        if self.fresh == (0.0, 0.0):
            self.fresh = similarity, likeness
        self.matches += 1
        loss = self.fresh[1] - likeness
        self._worn = self._worn + 1 if loss > renewal else 0
        explained = self.fresh[0] - similarity <= EXPLAINED * loss
        return self._worn > 0 and (explained or self._worn >= PATIENCE)

    def likeness(self, window: Picture) -> float:
        """Zero-mean normalized correlation, -1..1; 0 where there is no texture."""
        leveled, norm = self._leveled
        b = window.ravel() - window.mean()
        norm *= float(np.sqrt(np.dot(b, b)))
        return float(np.dot(leveled, b)) / norm if norm > 0 else 0.0

    def align(self, part: Region, place: Floats) -> tuple[Floats, float, float]:
        """Tell turns and changes of size from motion.

        Least squares of the window by the template that is moved, turned, scaled, brightened and
        exposed a little, all at a time (Hager and Belhumeur 1998). Matching alone takes part of a
        turn for a motion, and with each new template so found the target would drift away.

        :param place: (u, v) of the window's center, within about a pixel [px].
        :return: the place corrected; the similarity there, which is the coefficient of multiple
            correlation, near 1 for a window that is the template so changed, and less where
            something covers it; and the likeness.
        """
        ways, solver = self._ways
        for _ in range(STEPS):
            rest = self._rest(part, place)
            place = place + np.clip(solver[:2] @ rest, -STRIDE, STRIDE)
        rest = self._rest(part, place)
        window = self.picture.ravel() + rest
        rest = rest + (solver @ rest) @ ways
        unlike, total = float(np.dot(rest, rest)), float(window.var() * window.size)
        likeness = self.likeness(window)
        if likeness <= 0 or total <= unlike:
            return place, 0.0, likeness
        return place, float(np.sqrt(1 - unlike / total)), likeness

    def _rest(self, part: Region, place: Floats) -> Picture:
        return (part.window(place, self.picture.shape) - self.picture).ravel()

    @cached_property
    def _leveled(self) -> tuple[Picture, float]:
        """The picture less its mean, (n,), and its norm."""
        leveled = self.picture.ravel() - self.picture.mean()
        return leveled, float(np.sqrt(np.dot(leveled, leveled)))

    @cached_property
    def _ways(self) -> tuple[Picture, Picture]:
        """How the n pixels of a moving window change, (6, n), and what solves for it, (6, n)."""
        dv, du = np.gradient(self.picture)
        h, w = self.picture.shape
        v, u = np.arange(h)[:, None] - h // 2, np.arange(w) - w // 2
        ways = [du, dv, u * du + v * dv, u * dv - v * du, self.picture, np.ones((h, w))]
        A = np.stack([way.ravel() for way in ways]).astype(float)
        solver = -np.linalg.pinv(A @ A.T, hermitian=True) @ A
        return A.astype(np.float32), solver.astype(np.float32)
