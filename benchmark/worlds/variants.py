"""Issue point 15: options that lost where the default did not."""

from functools import cache
from functools import partial
from pathlib import Path

import numpy as np
from points import JUGGLING
from points import labels
from points import of_scene
import yaml

from worlds.identities import pedestrians
from worlds.motions import in_a_box
from worlds.world import Figure
from worlds.world import judge
from worlds.world import observe
from worlds.world import places
from worlds.world import play

PEGORETTI = Path(__file__).parents[2] / 'params' / 'pegoretti.yaml'
SCENES = ('collision?duration=4', 'swarm?duration=4', 'crossing?duration=4')
DOCUMENT = tuple(
    f'{name}?duration=6' for name in ('single', 'enter_exit', 'five', 'crossing', 'occlusion')
)
OPTIONS = {
    'jpda': {'associator': 'jpda'},
    'imm': {'motion_model': 'imm'},
    'constant_acceleration': {'motion_model': 'constant_acceleration'},
}
scene = cache(partial(of_scene, noise=0.5))


def idf1(sequences, **options):
    """Mean of the sequences [%]."""
    played = [judge(one, places(play(one.detections, **options))) for one in sequences]
    return 100 * float(np.mean([score.idf1 for score in played]))


def compare(what, sequences, **options):
    """The option as now, the default as its rival, less five points as what is to be reached."""
    default = idf1(sequences)
    now = idf1(sequences, **options)
    yield Figure(f'{what}: IDF1 %', now, rival=default, low=default - 5.0)


def overlapping(seed, rivals, option):
    for name in SCENES:
        yield from compare(name, [scene(name, seed=seed)], **OPTIONS[option])
    rng = np.random.default_rng(seed)
    for name, sequence in (
        ('points that pass', observe(in_a_box(rng, 30, 300), rng, 2.0).sequence()),
        ('pedestrians', pedestrians(rng, 'boxes')),
        ('merging blobs', pedestrians(rng, 'blobs')),
    ):
        yield from compare(name, [sequence], **OPTIONS[option])


def juggling(seed, rivals, option):
    """The labels of all patterns; none where the data is not."""
    files = sorted(JUGGLING.glob('*.csv'))[seed::3]
    if files:
        yield from compare('juggling', [labels(file) for file in files], **OPTIONS[option])


def pegoretti(seed, rivals):
    """The document's values on the document's scenes."""
    nodes = yaml.safe_load(PEGORETTI.read_text())
    values = nodes['/**/tracker']['ros__parameters']
    for name in DOCUMENT:
        yield from compare(name, [scene(name, seed=seed)], **values)


WORLDS = (
    {f'15 overlapping, {o}': partial(overlapping, option=o) for o in OPTIONS}
    | {f'15 juggling, {o}': partial(juggling, option=o) for o in OPTIONS}
    | {'15 pegoretti.yaml': pegoretti}
)
