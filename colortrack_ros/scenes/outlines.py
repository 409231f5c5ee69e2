"""Scenes for trackers that follow outlines.

Points of a path are (x, y, radius): x in widths and y and radius in heights of the picture; the
radius is that of the disc of the same area.
"""

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import ArrayLike

from colortrack_ros.scenes.curves import constant
from colortrack_ros.scenes.curves import Curve
from colortrack_ros.scenes.curves import spline
from colortrack_ros.scenes.options import Options
from colortrack_ros.scenes.pegoretti import in_pixels
from colortrack_ros.scenes.scene import Scene
from colortrack_ros.scenes.silhouettes import arc
from colortrack_ros.scenes.silhouettes import normalized
from colortrack_ros.scenes.silhouettes import Silhouette
from colortrack_ros.scenes.texture import Color
from colortrack_ros.scenes.texture import plaster

PAPER: Color = (224, 224, 220)
ARENA: Color = (176, 170, 160)
DARK: dict[str, Color] = {'person': (44, 42, 46), 'quadrilateral': (52, 50, 48)}
ROBOTS: dict[str, Color] = {
    'robot_a': (62, 44, 48),
    'robot_b': (40, 54, 70),
    'robot_c': (46, 60, 46),
    'robot_d': (56, 56, 60),
}
"""Colors, dark on light as in De Bem 2007, 6.1; chosen."""

DIAGONAL = math.sqrt(0.5)
PERSON = np.concatenate(
    [
        arc((0.0, -0.62), 0.42, (0.0, -1.0), 2.5),  # the head, open at the neck
        [(0.2, -0.05)],
        arc((0.55, 0.4), 0.4, (DIAGONAL, -DIAGONAL), 0.4142),
        [(0.98, 1.0), (-0.98, 1.0)],
        arc((-0.55, 0.4), 0.4, (-DIAGONAL, -DIAGONAL), 0.4142),
        [(-0.2, -0.05)],
    ]
)
QUADRILATERAL = [(-1.0, -0.8), (0.9, -1.0), (1.1, 0.9), (-0.9, 1.0)]
"""Head and shoulders, and a quadrilateral, as in De Bem 2007, 6.1; drawn by hand."""


def silhouette(options: Options) -> Scene:
    """Return head and shoulders of a person, and a quadrilateral, dark on light (De Bem 2007, 6.1).

    After one second of empty background they come in from the sides within another. Then the person
    moves up, down and across, and the quadrilateral recedes from the camera and moves up and down.
    """
    times = [0.2, 1.2, 2.2, 4.2, 6.2, 8.7, 11.2, 13.7, 16.0, 18.5, 21.0]
    person = [
        (-0.40, 0.55, 0.14), (-0.14, 0.55, 0.14), (0.15, 0.55, 0.14), (0.24, 0.44, 0.14),
        (0.24, 0.36, 0.145), (0.25, 0.58, 0.15), (0.34, 0.64, 0.15), (0.40, 0.46, 0.15),
        (0.30, 0.40, 0.14), (0.24, 0.50, 0.13), (0.27, 0.56, 0.13),
    ]  # fmt: skip
    other = [
        (1.40, 0.60, 0.15), (1.16, 0.60, 0.15), (0.86, 0.60, 0.15), (0.76, 0.62, 0.145),
        (0.75, 0.50, 0.135), (0.75, 0.40, 0.12), (0.74, 0.52, 0.11), (0.72, 0.64, 0.10),
        (0.72, 0.54, 0.105), (0.74, 0.44, 0.12), (0.76, 0.50, 0.125),
    ]  # fmt: skip
    things = [
        _thing(options, 'person', PERSON, times, person),
        _thing(options, 'quadrilateral', QUADRILATERAL, times, other),
    ]
    wall = plaster((options.seed, 0), options.height, options.width, PAPER, contrast=0.0)
    return Scene('silhouette', options, wall, DARK, things)


def approach(options: Options) -> Scene:
    """Return four robots that approach the camera and grow fourfold (De Bem 2007, 6.2).

    After one second of empty background they come in from the sides, far away, within two more.
    """
    times = [0.2, 1.2, 2.2, 3.2, 5.0, 8.5, 12.0, 16.0, 19.0, 22.0]
    y = [0.18, 0.18, 0.18, 0.19, 0.22, 0.31, 0.43, 0.56, 0.64, 0.70]
    size = [0.030, 0.030, 0.030, 0.031, 0.034, 0.046, 0.066, 0.090, 0.106, 0.118]
    things = []
    for i, (name, shape, marks) in enumerate(_robots()):
        side = -1 if i < 2 else 1
        far = 0.5 + side * (0.13 if i in (1, 2) else 0.26)
        near = 0.5 + side * (0.125 if i in (1, 2) else 0.375)
        x = [
            0.5 + side * (1.0 if i in (1, 2) else 1.13),
            0.5 + side * (0.56 if i in (1, 2) else 0.69),
            0.0,
            far,
        ]
        x[2] = (x[1] + far) / 2
        x += [far + (near - far) * (s - 0.031) / 0.087 for s in size[4:]]
        x = [c + 0.012 * (-1) ** (k // 2 + i) * (k > 3) for k, c in enumerate(x)]
        things.append(
            _thing(options, name, shape, times, np.stack([x, y, size], axis=1), marks=marks)
        )
    floor = plaster((options.seed, 0), options.height, options.width, ARENA, contrast=0.4)
    return Scene('approach', options, floor, ROBOTS, things)


def _robots() -> list[tuple[str, ArrayLike, list[tuple[ArrayLike, Color]]]]:
    """Return names, outlines and marks of four robots."""
    window = [(-0.5, -0.5), (0.5, -0.5), (0.4, 0.0), (-0.4, 0.0)]
    box = [(-0.9, -0.7), (0.9, -0.7), (1.0, 0.4), (0.8, 1.0), (-0.8, 1.0), (-1.0, 0.4)]
    dome = np.concatenate([arc((0, 0), 1.0, (0.0, -1.0), 1.0), [(1.0, 0.9), (-1.0, 0.9)]])
    tower = [(-0.5, -1.3), (0.5, -1.3), (0.6, 0.1), (1.0, 0.2), (1.0, 1.0), (-1.0, 1.0),
             (-1.0, 0.2), (-0.6, 0.1)]  # fmt: skip
    wedge = [(-0.4, -1.0), (0.4, -1.0), (1.1, 1.0), (-1.1, 1.0)]
    return [
        ('robot_a', box, [(window, (118, 96, 90))]),
        ('robot_b', dome, [(window, (90, 112, 130))]),
        ('robot_c', tower, [(window, (92, 120, 92))]),
        ('robot_d', wedge, []),
    ]


def _thing(
    options: Options,
    name: str,
    shape: ArrayLike,
    times: ArrayLike,
    points: ArrayLike,
    turn: Curve | None = None,
    marks: Sequence[tuple[ArrayLike, Color]] = (),
) -> Silhouette:
    outline, center, scale = normalized(shape)
    return Silhouette(
        spline(times, in_pixels(options, points)),
        name,
        outline=outline,
        turn=constant(0.0) if turn is None else turn,
        marks=tuple(((np.asarray(mark) - center) / scale, color) for mark, color in marks),
    )
