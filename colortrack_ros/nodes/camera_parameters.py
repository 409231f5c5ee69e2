"""The parameters of the camera node."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sensor_msgs.msg import CameraInfo

from colortrack_ros.messages import load_camera_info
from colortrack_ros.node_kit.diagnostics import HEALTH
from colortrack_ros.node_kit.live_parameters import own_values
from colortrack_ros.node_kit.topics import DEPTH
from colortrack_ros.node_kit.topics import PICTURE_DEPTH
from colortrack_ros.node_kit.topics import topic
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import Spec
from colortrack_ros.sources.stream import without_secrets

TABLE = ParameterTable(
    [
        Spec(
            'source',
            '0',
            'A device (its number or /dev/video*), a video file, an rtsp:// or http:// stream, a '
            'folder or glob of pictures, or scene:NAME.',
            read_only=True,
            shown=without_secrets,
        ),
        Spec(
            'rate',
            0.0,
            'Frames published per second; 0 is the rate of the source, -1 as fast as a recording '
            'is consumed by the detector. The stamps of a recording keep its own frame period.',
            unit='Hz',
            minimum=-1.0,
            maximum=1000.0,
        ),
        Spec('loop', False, 'Whether a recording starts again when it has ended.'),
        Spec('exit_at_end', False, 'Whether the node ends when a recording has ended.'),
        Spec('frame_id', 'camera_optical_frame', 'Coordinate frame of the camera.'),
        Spec(
            'camera_info_url',
            '',
            'Calibration as camera_calibration writes it: file://, package:// or a path; empty '
            'for none.',
        ),
        Spec('jpeg_quality', 90, 'Quality of the compressed pictures.', minimum=1, maximum=100),
        Spec(
            'wait_for_subscribers',
            0,
            'A recording starts when so many subscribe to image_topic.',
            minimum=0,
            maximum=100,
            read_only=True,
        ),
        topic('image_topic', 'camera/image_raw', 'the pictures that are published'),
        topic('camera_info_topic', 'camera/camera_info', 'the calibration that is published'),
        topic('detections_topic', 'detections', 'the detections that rate -1 waits for'),
        PICTURE_DEPTH,
        DEPTH,
        *HEALTH,
    ]
)


@dataclass(frozen=True)
class CameraSetup:
    """The checked values, and the calibration that ``camera_info_url`` names."""

    source: str
    rate: float
    loop: bool
    exit_at_end: bool
    frame_id: str
    camera_info: CameraInfo
    jpeg_quality: int
    wait_for_subscribers: int
    image_topic: str
    camera_info_topic: str
    detections_topic: str

    @property
    def as_consumed(self) -> bool:
        """Whether a recording goes as fast as it is consumed."""
        return self.rate == -1.0


def build(values: Mapping[str, Any]) -> CameraSetup:
    """The setup of a camera.

    :raises ValueError: a rate between -1 and 0, or a calibration that cannot be read.
    """
    if -1.0 < values['rate'] < 0.0:
        raise ValueError(f'rate: expected -1, 0, or a positive number, got {values["rate"]}')
    info = load_camera_info(values['camera_info_url'])
    return CameraSetup(camera_info=info, **own_values(CameraSetup, values))
