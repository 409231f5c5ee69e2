"""The parameters of the camera node."""

from dataclasses import dataclass

from colortrack_ros.messages import load_camera_info
from colortrack_ros.node_kit.node_setup import NodeSetup
from colortrack_ros.node_kit.topics import PictureQueueConfig
from colortrack_ros.node_kit.topics import topic_name
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import parameter
from colortrack_ros.parameters import part
from colortrack_ros.sources.device import DeviceConfig
from colortrack_ros.sources.stream import without_secrets


@dataclass(frozen=True)
class CameraSetup(NodeSetup):
    """The parameters of the camera node."""

    source: str = parameter(
        '0',
        'A device (its number or /dev/video*), a video file, an rtsp:// or http:// stream, a '
        'folder or glob of pictures, or scene:NAME.',
        read_only=True,
        shown=without_secrets,
        int_is_text=True,
    )
    rate: float = parameter(
        0.0,
        'Frames published per second; 0 is the rate of the source, -1 as fast as a recording is '
        'consumed by the detector. The stamps of a recording keep its own frame period.',
        unit='Hz',
        limits=(-1.0, 1000.0),
    )
    loop: bool = parameter(False, 'Whether a recording starts again when it has ended.')
    exit_at_end: bool = parameter(
        False,
        'Whether the node ends when a recording has ended; with status 1 if it was damaged.',
    )
    frame_id: str = parameter('camera_optical_frame', 'Coordinate frame of the camera.')
    camera_info_url: str = parameter(
        '',
        'Calibration as camera_calibration writes it: file://, package:// or a path, or none.',
        valid=load_camera_info,
    )
    jpeg_quality: int = parameter(
        90, 'Quality of the compressed pictures.', limits=(1, 100), audience=EXPERT
    )
    wait_for_subscribers: int = parameter(
        0,
        'A recording starts once this many nodes subscribe to image_topic.',
        limits=(0, 100),
        audience=EXPERT,
        read_only=True,
    )
    device: DeviceConfig = part(DeviceConfig)
    image_topic: str = topic_name('camera/image_raw', 'the pictures that are published')
    camera_info_topic: str = topic_name('camera/camera_info', 'the calibration that is published')
    detections_topic: str = topic_name('detections', 'the detections that rate -1 waits for')
    pictures: PictureQueueConfig = part(PictureQueueConfig)

    @property
    def as_consumed(self) -> bool:
        """Whether a recording is played as fast as it is consumed."""
        return self.rate == -1.0

    def check(self) -> None:
        """Raise ValueError for a rate between -1 and 0."""
        if -1.0 < self.rate < 0.0:
            raise ValueError(f'rate: expected -1, 0, or a positive number, got {self.rate}')
