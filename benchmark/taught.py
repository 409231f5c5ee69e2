"""What colors find that are taught as a new user does: click, look, click on what is false.

python benchmark/taught.py [--seeds 0 1 2] [--size 640x360] [--videos FOLDER] [--pictures FOLDER]:
each object is shown by three clicks in three pictures. Then twelve pictures are looked at, and the
largest thing that is found and is false is clicked on as the room, up to five times. Scenes bring
their truth; each seed has other clicks, another wall and other noise. FOLDER of the videos holds
the three of a tossed ball, which get one color: a click in each, and five of the room. With
--constants, each constant of the division of colors is halved and doubled.
"""

import argparse
from collections.abc import Iterator
from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import cv2
from films import SceneFilm
from films import TossedFilm
from films import VIDEOS
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import discriminate
from colortrack_ros.detection.pick import side_by_side
from colortrack_ros.detection.teach import Example
from colortrack_ros.detection.teach import teach_color

SCENES = ('clutter', 'light')
CLICKS, ROOM, LOOKS = 3, 5, 12
"""Clicks on each object, on the room at most, and pictures that are looked at."""

NEEDED = 0.5
"""Least visible share of a ball that has to be found."""

CONSTANTS = (
    'SMOOTHING', 'SHADE_RADIUS', 'SHADES_SHARE', 'SEEN_SHARE', 'WHOLE_SHARE',
    'SPILLED_AREA',
)  # fmt: skip


Film = SceneFilm | TossedFilm


@dataclass
class Lesson:
    """What a new user teaches.

    :param film: shows the objects.
    :param seed: of the clicks.
    :param parameters: of the detector.
    """

    film: Film
    seed: int
    parameters: dict[str, int]

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng(self.seed)
        self.clicks = [self._clicks_on(color) for color in range(len(self.film.colors))]
        self.room: list[Example] = []
        for _ in range(ROOM):
            place = self._largest_false()
            if place is None:
                break
            self.room.append(place)
            self.__dict__.pop('config', None)

    @cached_property
    def config(self) -> DetectorConfig:
        """The colors with their limits, as pick_color writes them."""
        colors, shape = [], dict[str, float]()
        for name, clicks in zip(self.film.colors, self.clicks, strict=True):
            picked = teach_color(clicks, self.room, name)
            limits = dict(picked.limits)
            areas = {key: int(limits.pop(key, 0)) for key in ('min_area', 'max_area')}
            colors.append(replace(picked.color, **areas))
            shape |= limits
        return DetectorConfig(colors=tuple(colors), **shape, **self.parameters)

    def _clicks_on(self, color: int) -> list[Example]:
        """Clicks on objects that are wholly seen, within half of their radius."""
        film, rng, clicks = self.film, self._rng, []
        for third, part in enumerate(film.parts):
            seen = [
                (k, ball)
                for k in part
                for ball in film.truth(k)
                if ball['color'] == color and ball['visible'] == 1
            ]
            if isinstance(film, SceneFilm):
                seen = [seen[i] for i in np.array_split(np.arange(len(seen)), CLICKS)[third]]
            k, ball = seen[rng.integers(len(seen))]
            away, turn = rng.uniform(0, 0.5) * ball['radius'], rng.uniform(0, 2 * np.pi)
            u, v = ball['u'] + away * np.cos(turn), ball['v'] + away * np.sin(turn)
            clicks.append(Example(film.frame(k), (round(u), round(v), 1, 1)))
        return clicks

    def looks(self) -> Iterator[int]:
        """The frames that are looked at."""
        rng = np.random.default_rng(self.seed + 1)
        for part in self.film.parts:
            yield from rng.choice(part, LOOKS // CLICKS, replace=False).tolist()

    def _largest_false(self) -> Example | None:
        """A click on the deepest point of the largest thing that is false."""
        largest, place = 0.0, None
        try:
            config = self.config
        except ValueError:
            return self._anywhere()
        for k in self.looks():
            detector, frame = Detector(config), self.film.frame(k)
            rows = detector.detect(frame).rows
            for row in rows[~near_any(rows, self.film.truth(k))]:
                if row['area'] <= largest:
                    continue
                left, top, width, height = (int(row[f'box_{x}']) for x in 'uvwh')
                part = detector.labels[top : top + height, left : left + width] == row['color'] + 1
                depth = cv2.distanceTransform(np.pad(part.view(np.uint8), 1), cv2.DIST_L2, 3)
                v, u = np.unravel_index(depth[1:-1, 1:-1].argmax(), part.shape)
                largest, place = row['area'], Example(frame, (left + int(u), top + int(v), 1, 1))
        return place

    def _anywhere(self) -> Example:
        """A click beside the objects, since the colors were refused: they fill the pictures."""
        k = next(self.looks())
        frame, truth = self.film.frame(k), self.film.truth(k)
        height, width = frame.image.shape[:2]
        while True:
            u, v = int(self._rng.integers(width)), int(self._rng.integers(height))
            if all(np.hypot(b['u'] - u, b['v'] - v) > 3 * b['radius'] for b in truth):
                return Example(frame, (u, v, 1, 1))


def near_any(rows: NDArray[np.void], truth: NDArray[np.void]) -> NDArray[np.bool_]:
    """(N,) whether detections are at a ball of any color, within 1.5 radii."""
    away = np.hypot(*(rows[x][:, None] - truth[x] for x in 'uv'))
    return np.asarray((away < 1.5 * truth['radius']).any(axis=1))


def judge(film: Film, config: DetectorConfig, frames: Sequence[int]) -> list[float]:
    """Recall, false detections in a frame, RMSE [px], and NSE of what is wholly seen."""
    detector = Detector(config)
    due, false, errors, squared = 0, 0, list[float](), list[float]()
    for k in frames:
        rows, truth = detector.detect(film.frame(k)).rows, film.truth(k)
        false += int(np.count_nonzero(~near_any(rows, truth)))
        for ball in truth[truth['visible'] >= NEEDED]:
            mine = rows[rows['color'] == ball['color']]
            error = np.stack([mine[x] - ball[x] for x in 'uv'], axis=1)
            away = np.hypot(*error.T)
            due += 1
            if away.min(initial=np.inf) < ball['radius']:
                row, error = mine[away.argmin()], error[away.argmin()]
                errors.append(float(away.min()))
                cov = [[row['cov_uu'], row['cov_uv']], [row['cov_uv'], row['cov_vv']]]
                if ball['visible'] == 1:
                    squared.append(error @ np.linalg.solve(cov, error) / 2)
    rmse = float(np.sqrt(np.mean(np.square(errors or [np.nan]))))
    return [len(errors) / due, false / len(frames), rmse, float(np.mean(squared or [np.nan]))]


def cell(numbers: Sequence[float]) -> str:
    """What a table shows of :func:`judge`."""
    recall, false, rmse, nse = numbers
    return f'{recall:.1%} / {false:.2f} / {rmse:.1f} / {nse:.2f}'


def show(lesson: Lesson, folder: Path, name: str) -> None:
    """Write pictures of what is found in the frames that are looked at."""
    folder.mkdir(parents=True, exist_ok=True)
    for k in lesson.looks():
        picture = side_by_side(lesson.film.frame(k), Detector(lesson.config))
        cv2.imwrite(str(folder / f'{name}_{k}.png'), picture)


def parse() -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seeds', nargs='*', type=int, default=[0, 1, 2])
    parser.add_argument('--size', default='640x360')
    parser.add_argument('--videos', type=Path, default=VIDEOS)
    parser.add_argument('--pictures', type=Path)
    parser.add_argument('--constants', nargs='*', help='halve and double these, or all')
    return parser.parse_args()


def lessons(arguments: argparse.Namespace) -> Iterator[tuple[str, Lesson]]:
    """The lessons of all films, one for each seed."""
    width, height = arguments.size.split('x')
    for seed in arguments.seeds:
        for name in SCENES:
            spec = f'{name}?width={width}&height={height}&seed={seed}'
            yield f'{name} {seed}', Lesson(SceneFilm(spec), seed, {})
    if arguments.videos.is_dir() and arguments.constants is None:
        film = TossedFilm(arguments.videos)
        for seed in arguments.seeds:
            for closing in (1, 9):
                lesson = Lesson(film, seed, {'closing_size': closing})
                yield f'ball_toss {seed}, closing_size {closing}', lesson


def sensitivity(arguments: argparse.Namespace) -> Iterator[list[str]]:
    """A row for half and for twice of each constant: means over the scenes."""
    for name in arguments.constants or CONSTANTS:
        value = getattr(discriminate, name)
        for factor in (0.5, 1.0, 2.0):
            changed = factor * value
            setattr(discriminate, name, min(changed, 1.0) if value < 1 else changed)
            results = [
                judge(lesson.film, lesson.config, lesson.film.parts[0][::4])
                for _, lesson in lessons(arguments)
            ]
            yield [f'{name} {factor:g}', cell(np.mean(results, axis=0).tolist())]
        setattr(discriminate, name, value)


def main() -> None:
    """Print the table."""
    arguments = parse()
    table = Table(title='recall / false detections in a frame / RMSE [px] / NSE')
    for column in ('film, seed', 'result', 'shades, others'):
        table.add_column(column)
    if arguments.constants is not None:
        for row in sensitivity(arguments):
            table.add_row(*row)
    else:
        for name, lesson in lessons(arguments):
            shades = [(1 + len(c.samples), len(c.others)) for c in lesson.config.colors]
            for part in dict.fromkeys(lesson.film.parts):
                result = cell(judge(lesson.film, lesson.config, part))
                table.add_row(name, result, f'{len(lesson.room)} of the room: {shades}')
            if arguments.pictures:
                show(lesson, arguments.pictures, name.replace(' ', '_'))
    Console().print(table)


if __name__ == '__main__':
    main()
