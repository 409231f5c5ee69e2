"""The recipe of the golden recording: ``python test/golden/make.py``, after a wanted change.

Five balls pass behind a bar. The bag holds their detections, tracks.csv what the tracker makes of
them; contours.csv is what the contour tracker makes of another scene. Look at what has changed
before you commit it.
"""

from pathlib import Path
import shutil
import tempfile

from colortrack_ros.bags import BagReader
from colortrack_ros.bags import BagWriter
from colortrack_ros.replay.main import main

HERE = Path(__file__).parent
SCENE = 'scene:occlusion?width=320&height=240&rate=8'
TOPIC = '/detections'
CONTOURS = ['scene:silhouette?width=160&height=120&rate=5', '--tracker', 'contour_tracker']


def make_bag(folder: Path) -> None:
    """Replay the scene, and keep its detections alone."""
    with tempfile.TemporaryDirectory() as scratch:
        whole = Path(scratch) / 'whole'
        assert main([SCENE, '--output', str(whole)]) == 0
        reader = BagReader(whole)
        (topic,) = (topic for topic in reader.topics if topic.name == TOPIC)
        bag = BagWriter(folder, {topic.name: topic.kind})
        for log_time, cdr in reader.messages(topic):
            bag.write(TOPIC, log_time, cdr)
        bag.close()
        reader.close()


def make_tracks(table: Path, *source: str) -> None:
    """Track a recording: its input, and further arguments of replay."""
    with tempfile.TemporaryDirectory() as scratch:
        assert main([*source, '--output', f'{scratch}/new', '--csv', str(table), '--force']) == 0


if __name__ == '__main__':
    shutil.rmtree(HERE / 'bag', ignore_errors=True)
    make_bag(HERE / 'bag')
    make_tracks(HERE / 'tracks.csv', str(HERE / 'bag'))
    make_tracks(HERE / 'contours.csv', *CONTOURS)
