"""scenes: rendered sequences with ground truth, bit-identical on every machine."""

from collections.abc import Callable

from colortrack_ros.scenes.harder import blackout
from colortrack_ros.scenes.harder import collision
from colortrack_ros.scenes.harder import flicker
from colortrack_ros.scenes.harder import juggle
from colortrack_ros.scenes.harder import swarm
from colortrack_ros.scenes.harder import turns
from colortrack_ros.scenes.harder import vanish
from colortrack_ros.scenes.ideal import BLACKOUT
from colortrack_ros.scenes.ideal import detections_of
from colortrack_ros.scenes.options import Options
from colortrack_ros.scenes.options import parse_options
from colortrack_ros.scenes.outlines import approach
from colortrack_ros.scenes.outlines import silhouette
from colortrack_ros.scenes.pegoretti import crossing
from colortrack_ros.scenes.pegoretti import enter_exit
from colortrack_ros.scenes.pegoretti import five
from colortrack_ros.scenes.pegoretti import occlusion
from colortrack_ros.scenes.pegoretti import single
from colortrack_ros.scenes.red_object import red_curve
from colortrack_ros.scenes.red_object import red_hidden
from colortrack_ros.scenes.red_object import red_object
from colortrack_ros.scenes.red_object import red_pair
from colortrack_ros.scenes.red_object import red_throw
from colortrack_ros.scenes.rooms import clutter
from colortrack_ros.scenes.rooms import fast
from colortrack_ros.scenes.rooms import light
from colortrack_ros.scenes.scene import Scene
from colortrack_ros.scenes.scene import TRUTH
from colortrack_ros.scenes.windows import window_clutter
from colortrack_ros.scenes.windows import window_hidden
from colortrack_ros.scenes.windows import window_jump
from colortrack_ros.scenes.windows import window_partial
from colortrack_ros.scenes.windows import window_texture

__all__ = ['BLACKOUT', 'SCENES', 'TRUTH', 'Options', 'Scene', 'detections_of', 'open_scene']

SCENES: dict[str, Callable[[Options], Scene]] = {
    'single': single,
    'enter_exit': enter_exit,
    'five': five,
    'crossing': crossing,
    'occlusion': occlusion,
    'collision': collision,
    'swarm': swarm,
    'juggle': juggle,
    'turns': turns,
    'blackout': blackout,
    'flicker': flicker,
    'vanish': vanish,
    'clutter': clutter,
    'light': light,
    'fast': fast,
    'window_texture': window_texture,
    'window_clutter': window_clutter,
    'window_partial': window_partial,
    'window_hidden': window_hidden,
    'window_jump': window_jump,
    'silhouette': silhouette,
    'approach': approach,
    'red_object': red_object,
    'red_pair': red_pair,
    'red_hidden': red_hidden,
    'red_throw': red_throw,
    'red_curve': red_curve,
}
"""Functions that build the scenes, by name."""


def open_scene(spec: str) -> Scene:
    """Return the scene with a name and, after a question mark, options: `five?width=640&noise=0`.

    :raises ValueError: for an unknown scene or option, or an invalid value; the message names what
        was given and what is possible.
    """
    name, _, query = spec.partition('?')
    if name not in SCENES:
        raise ValueError(f'unknown scene {name!r}: there are {", ".join(SCENES)}')
    return SCENES[name](parse_options(query))
