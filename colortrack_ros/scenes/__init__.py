"""scenes: rendered sequences with their ground truth, the same to the bit on every machine."""

from collections.abc import Callable

from colortrack_ros.scenes.options import Options
from colortrack_ros.scenes.options import parse_options
from colortrack_ros.scenes.pegoretti import crossing
from colortrack_ros.scenes.pegoretti import enter_exit
from colortrack_ros.scenes.pegoretti import five
from colortrack_ros.scenes.pegoretti import occlusion
from colortrack_ros.scenes.pegoretti import single
from colortrack_ros.scenes.scene import Scene
from colortrack_ros.scenes.scene import TRUTH

__all__ = ['SCENES', 'TRUTH', 'Options', 'Scene', 'open_scene']

SCENES: dict[str, Callable[[Options], Scene]] = {
    'single': single,
    'enter_exit': enter_exit,
    'five': five,
    'crossing': crossing,
    'occlusion': occlusion,
}
"""Every scene by its name: a function that builds it."""


def open_scene(spec: str) -> Scene:
    """Return the scene of a name and, after a question mark, options: `five?width=640&noise=0`.

    :raises ValueError: for an unknown scene or option, or a bad value of one, naming what was
        given and what there is.
    """
    name, _, query = spec.partition('?')
    if name not in SCENES:
        raise ValueError(f'unknown scene {name!r}: there are {", ".join(SCENES)}')
    return SCENES[name](parse_options(query))
