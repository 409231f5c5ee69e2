"""Things in a real kitchen, by a depth camera in a hand: how near, and how honest.

python benchmark/real_depth.py FOLDER, where FOLDER is data/ of the public repository
andyzeng/tsdf-fusion-python: 1,000 color and depth pictures of 640x480 with the pose of the depth
camera in each. The depth is not aligned with the color there; how it lies was found by what aligns
edges in both. Three colors, one pixel each and nothing else, find magazines, brochures and boxes,
no balls; their diameters are not given. Errors are along the ray, against the surface in the same
picture (median of 9x9 depths), which is where the center of something flat is.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from rich.console import Console
from rich.table import Table

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig
from colortrack_ros.world import CameraModel
from colortrack_ros.world import Locator
from colortrack_ros.world import LocatorConfig
from colortrack_ros.world import Pose
from colortrack_ros.world.config import Kind
from colortrack_ros.world.config import KindConfig
from colortrack_ros.world.poses import OPTICAL
from colortrack_ros.world.view import View

COLORS = {'purple': (146, 110, 154), 'dark blue': (60, 40, 110), 'light blue': (40, 140, 180)}
DEPTH_FOCAL, FOCAL = 585.0, 525.0
CENTER = np.array([320.0, 240.0])
OFFSET = np.array([-0.02, -0.01, 0.0])
"""Of what the depth camera sees, to the color camera [m]."""

LENS = CameraModel.of(640, 480, (FOCAL, 0, 320, 0, FOCAL, 240, 0, 0, 1))
STANDS = Pose.of_rpy((0, 0, 0), (0, 0, 0))


def aligned(raw):
    """The depth picture as the color camera would see it [m], 0 in its holes."""
    v, u = np.nonzero((raw > 200) & (raw < 8000))
    z = raw[v, u] / 1000.0
    far_first = np.argsort(-z)
    u, v, z = u[far_first], v[far_first], z[far_first]
    xy = (np.stack([u, v], axis=1) - CENTER) / DEPTH_FOCAL * z[:, None] + OFFSET[:2]
    pixel = np.rint(xy / z[:, None] * FOCAL + CENTER).astype(int)
    inside = ((pixel >= 0) & (pixel < (640, 480))).all(axis=1)
    depth = np.zeros((480, 640), np.float32)
    depth[pixel[inside, 1], pixel[inside, 0]] = z[inside]
    return np.where(depth > 0, depth, cv2.dilate(depth, np.ones((2, 2))))


def pictures(folder):
    """Yield each picture, its depth, its view and its stamp."""
    for k, path in enumerate(sorted(folder.glob('*.color.jpg'))):
        stem = str(path).removesuffix('color.jpg')
        T = np.loadtxt(stem + 'pose.txt')
        optical = Pose(T[:3, 3] - T[:3, :3] @ OFFSET, T[:3, :3])
        depth = aligned(cv2.imread(stem + 'depth.png', cv2.IMREAD_UNCHANGED))
        stamp = round((k + 1) * 1e9 / 30)
        yield cv2.imread(str(path)), depth, View(LENS, optical @ OPTICAL.inverse(), STANDS), stamp


def surface(depth, pixel):
    """Depth of what is seen at a pixel [m]; NaN if it is not measured."""
    u, v = np.rint(pixel).astype(int)
    near = depth[max(v - 4, 0) : v + 5, max(u - 4, 0) : u + 5]
    return np.median(near[near > 0]) if (near > 0).sum() > 9 else np.nan


def errors(folder, rgb):
    """Errors along the ray and their standard deviations, (K, 2) [m]."""
    color = ReferenceColor.from_rgb('thing', rgb)
    detector = Detector(DetectorConfig(colors=(color,)))
    tracker = Tracker(TrackerConfig(ego_motion='odometry'))
    kind = Kind('thing', KindConfig(motion='free'))
    config = LocatorConfig('depth', (kind,), camera_pose_sigma=(0.005,) * 6)
    locator, found = Locator(config, lambda line: None), []
    for image, depth, view, stamp in pictures(folder):
        detections = replace(detector.detect(Frame(image, stamp=stamp)), viewpoint=view)
        tracks = tracker.update(detections)
        rows = locator.update(tracks, detections, view, depth).rows
        at = dict(zip(tracks.rows['track_id'].tolist(), tracks.rows, strict=True))
        for row in rows[rows['time_since_update'] == 0]:
            track = at[int(row['track_id'])]
            away = np.array([row['x'], row['y'], row['z']]) - view.optical.t
            ray = away / np.linalg.norm(away)
            seen = surface(depth, (track['u'], track['v'])) / (ray @ view.optical.R[:, 2])
            P = row['covariance'].reshape(6, 6)[:3, :3]
            found.append((np.linalg.norm(away) - seen, np.sqrt(ray @ P @ ray)))
    found = np.array(found)
    return found[np.isfinite(found[:, 0])]


def main():
    parser = argparse.ArgumentParser('real_depth', description=__doc__)
    parser.add_argument('folder', type=Path)
    a = parser.parse_args()
    if not list(a.folder.glob('*.color.jpg')):
        parser.exit(2, f'{a.folder}: no pictures\n')
    table = Table(title='Along the ray, from the surface')
    for column in ('color', 'places', 'median [m]', 'told [m]', '% within 95 %'):
        table.add_column(column)
    for name, rgb in COLORS.items():
        off, sigma = errors(a.folder, rgb).T
        within = 100 * np.mean(np.abs(off) < 1.96 * sigma)
        numbers = f'{np.median(off):+.3f}', f'{np.median(sigma):.3f}', f'{within:.0f}'
        table.add_row(name, str(len(off)), *numbers)
    Console(width=100).print(table)


if __name__ == '__main__':
    main()
