"""Pictures to match in, and scenes played once."""

from functools import cache

import cv2
import numpy as np

from colortrack_ros.data import Frame
from colortrack_ros.scenes import open_scene
from colortrack_ros.windows import WindowTracker


@cache
def texture(seed, height=120, width=160, cell=3.0):
    """Smooth random gray levels, (height, width) float32."""
    noise = np.random.default_rng(seed).normal(size=(height, width))
    smooth = cv2.GaussianBlur(noise, (0, 0), cell)
    gray = (128 + 40 * smooth / smooth.std()).astype(np.float32)
    gray.flags.writeable = False  # whoever asks again gets the same
    return gray


def frame(picture, k=0, rate=24.0):
    if picture.dtype != np.uint8:
        picture = np.clip(np.rint(picture), 0, 255).astype(np.uint8)
    return Frame(picture, 'mono8', round(k * 1e9 / rate))


@cache
def played(name, seed=0):
    """Frames (gray) and truth of a scene."""
    scene = open_scene(f'window_{name}?width=640&height=480&duration=10.5&seed={seed}')
    pictures = [cv2.cvtColor(scene.render(k), cv2.COLOR_BGR2GRAY) for k in range(len(scene))]
    return [frame(p, k, scene.rate) for k, p in enumerate(pictures)], [
        scene.truth(k) for k in range(len(scene))
    ]


def boxes(truth):
    """u, v, w, h of objects."""
    r = truth['radius'].astype(float)
    return np.stack([truth['u'] - r + 0.5, truth['v'] - r + 0.5, 2 * r, 2 * r], axis=1)


def errors(name, config, objects=None, seed=0):
    """Errors (frames, objects, 2) [px] of the first `objects` of a scene, NaN for no track, and
    covariances (frames, objects, 2, 2)."""
    frames, truth = played(name, seed)
    count = objects or len(truth[0])
    tracker = WindowTracker(config, boxes(truth[0][:count]))
    error = np.full((len(frames), count, 2), np.nan)
    covariance = np.full((len(frames), count, 2, 2), np.nan)
    for k, picture in enumerate(frames):
        for row in tracker.update(picture).rows:
            i = row['track_id'] - 1
            error[k, i] = row['u'] - truth[k]['u'][i], row['v'] - truth[k]['v'][i]
            covariance[k, i] = row['covariance'][:2, :2]
    return error, covariance
