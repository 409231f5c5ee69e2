"""Scenes for trackers that follow a texture: it rotates, resembles others, is covered, jumps.

Points of a path are (x, y, radius): x in widths and y and radius in heights of the picture. All
patches are in the picture from the first frame to the last.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from colortrack_ros.scenes.curves import constant
from colortrack_ros.scenes.curves import Curve
from colortrack_ros.scenes.curves import polyline
from colortrack_ros.scenes.curves import spline
from colortrack_ros.scenes.curves import to_and_fro
from colortrack_ros.scenes.options import Options
from colortrack_ros.scenes.patches import Patch
from colortrack_ros.scenes.patches import relief
from colortrack_ros.scenes.patches import texture
from colortrack_ros.scenes.pegoretti import BAR_COLOR
from colortrack_ros.scenes.pegoretti import in_pixels
from colortrack_ros.scenes.pegoretti import wall
from colortrack_ros.scenes.scene import Scene
from colortrack_ros.scenes.shapes import Cover
from colortrack_ros.scenes.texture import Color
from colortrack_ros.scenes.texture import plaster
from colortrack_ros.scenes.texture import uniform

PATCH_COLORS: dict[str, Color] = {'patch': (152, 128, 104)}
"""Chosen."""
PATCH_RADIUS = 0.05
"""Half the side of a patch, in heights of the picture: 36 px at 1280x720."""

LANES = (0.2, 0.5, 0.8)
"""Vertical positions of the lanes in which patches move, in heights of the picture: three that
never meet."""

LANE_SECONDS, TURN_SECONDS = 4.0, 1.2
"""Time from one end of a lane to the other, and for the way back and forth [s]."""

COVERED = 10 / 24
"""How long a cover hides the most that it can of a patch [s]. Chosen: ten frames at 24 Hz."""

LIKENESS = 0.8
"""Correlation between the textures of `window_clutter`. Chosen: at 1 they would be identical."""


def window_texture(options: Options) -> Scene:
    """Return three patches that wander, rotate by up to 33 degrees and change their size by
    half.
    """
    seconds = np.arange(-1.0, 24.0, 2.0)
    patches = []
    for i, middle in enumerate(LANES):
        shake = uniform((options.seed, 21, i), len(seconds), 4) - 0.5
        radius = PATCH_RADIUS * (1 + 0.5 * shake[:, 2:3])
        turn = spline(seconds, 0.6 * shake[:, 3:])
        points = np.concatenate([[0.5, middle] + shake[:, :2] * [0.7, 0.12], radius], axis=1)
        patches.append(_patch(options, i, spline(seconds, in_pixels(options, points)), turn))
    return _scene('window_texture', options, patches)


def window_clutter(options: Options) -> Scene:
    """Return one patch that moves back and forth among six similar ones, two of which move.

    The first is the one to follow. It passes the others at 1.2 times its side.
    """
    gap = 2.4 * PATCH_RADIUS
    ways = [[(x, 0.5) for x in (0.18, 0.82)]]
    ways += [[(x, 0.5 + side * gap)] * 2 for x in (0.3, 0.7) for side in (-1, 1)]
    ways += [[(x, 0.5 + side * 2 * gap) for x in (0.82, 0.18)] for side in (-1, 1)]
    common, own = relief((options.seed, 22)), np.sqrt(1 - LIKENESS * LIKENESS)
    patches = []
    for i, (start, end) in enumerate(ways):
        bumps = LIKENESS * common + own * relief((options.seed, 23, i))
        patches.append(_patch(options, i, _to_and_fro(options, start, end), bumps=bumps))
    return _scene('window_clutter', options, patches)


def window_partial(options: Options) -> Scene:
    """Return three patches that move back and forth, half covered for 10 frames each way."""
    bars = [
        (y, y + 1.5 * PATCH_RADIUS) if i % 2 else (y - 1.5 * PATCH_RADIUS, y)
        for i, y in enumerate(LANES)
    ]
    return _lanes('window_partial', options, bars)


def window_hidden(options: Options) -> Scene:
    """Return three patches that move back and forth, hidden for 10 frames each way."""
    return _lanes(
        'window_hidden', options, [(y - 1.5 * PATCH_RADIUS, y + 1.5 * PATCH_RADIUS) for y in LANES]
    )


def window_jump(options: Options) -> Scene:
    """Return two patches that move straight and suddenly change direction.

    They move 11 px a frame at 1280 columns, and turn by any angle some 20 times.
    """
    patches = []
    for i, left in enumerate((0.08, 0.58)):
        places = uniform((options.seed, 24, i), 120, 2) * [0.34, 0.8] + [left, 0.1]
        step = np.diff(places * [options.width, options.height], axis=0)
        way = np.sqrt((step * step).sum(axis=1))
        times = np.concatenate([[0.0], np.cumsum(way / (0.206 * options.width))])
        points = [(x, y, PATCH_RADIUS) for x, y in places]
        patches.append(_patch(options, i, polyline(times, in_pixels(options, points))))
    return _scene('window_jump', options, patches)


def _lanes(name: str, options: Options, bars: Sequence[tuple[float, float]]) -> Scene:
    """Return one patch moving back and forth in each lane, and a cover from top to bottom in the
    middle.
    """
    patches, covers = [], []
    for i, (y, (top, bottom)) in enumerate(zip(LANES, bars, strict=True)):
        path = _to_and_fro(options, (0.18, y), (0.82, y))
        patches.append(_patch(options, i, path))
        speed = float(path.slope(np.array([LANE_SECONDS / 2]))[0, 0])
        half = PATCH_RADIUS * options.height + speed * COVERED / 2
        left = max(round(options.width / 2 - half), 0)
        right = min(round(options.width / 2 + half), options.width)
        rows = round(top * options.height), round(bottom * options.height)
        picture = plaster((options.seed, 25, i), rows[1] - rows[0], right - left, BAR_COLOR)
        covers.append(Cover(rows[0], left, picture))
    return _scene(name, options, patches, covers)


def _to_and_fro(options: Options, start: tuple[float, float], end: tuple[float, float]) -> Curve:
    """Return the path straight from start to end and back, over and over."""
    ends = in_pixels(options, [(*start, PATCH_RADIUS), (*end, PATCH_RADIUS)])
    return to_and_fro(0.0, ends, LANE_SECONDS, TURN_SECONDS, 5)


def _patch(
    options: Options,
    number: int,
    path: Curve,
    turn: Curve | None = None,
    bumps: NDArray[np.float64] | None = None,
) -> Patch:
    bumps = relief((options.seed, 20, number)) if bumps is None else bumps
    return Patch(
        path,
        'patch',
        texture=texture(bumps, PATCH_COLORS['patch']),
        turn=constant(0.0) if turn is None else turn,
    )


def _scene(
    name: str, options: Options, patches: Sequence[Patch], covers: Sequence[Cover] = ()
) -> Scene:
    return Scene(name, options, wall(options), PATCH_COLORS, patches, covers)
