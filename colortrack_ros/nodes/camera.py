"""The camera node: publishes pictures from a device, a file, a stream, a folder or a scene."""

from collections.abc import Callable
import dataclasses
import threading
from typing import Any
from typing import TYPE_CHECKING

from rclpy.logging import LoggingSeverity
from rclpy.subscription import Subscription
from sensor_msgs.msg import CameraInfo
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import SetBool

from colortrack_ros.data import Frame
from colortrack_ros.data import NANOSECONDS
from colortrack_ros.flow.pacing import Pacer
from colortrack_ros.flow.pacing import Window
from colortrack_ros.messages import compressed_of_frame
from colortrack_ros.messages import detections_of_serialized_cloud
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import MessageError
from colortrack_ros.node_kit.calibration import CalibrationServer
from colortrack_ros.node_kit.clocks import await_clock
from colortrack_ros.node_kit.clocks import Elapsed
from colortrack_ros.node_kit.diagnostics import Health
from colortrack_ros.node_kit.managed import ManagedNode
from colortrack_ros.node_kit.runtime import run
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.node_kit.services import offer
from colortrack_ros.node_kit.topics import publish_on
from colortrack_ros.node_kit.topics import subscribe_to
from colortrack_ros.nodes.camera_setup import CameraSetup
from colortrack_ros.nodes.camera_source import open_first
from colortrack_ros.nodes.camera_source import Reopening
from colortrack_ros.sources import Grabber
from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError
from colortrack_ros.sources.device import DeviceSource

if TYPE_CHECKING:  # it would bring SciPy, half of the time that a camera takes to start
    from colortrack_ros.chain import ColorChain

IN_FLIGHT = 2
"""Frames that may wait for their detections when a recording is played as fast as it is consumed:
the one being processed, and the next, so that the detector never idles."""
ACQUAINTANCE = 0.5
"""Time [s] for subscribers that the camera has discovered to discover the camera: discovery
completes on one side first."""
MOST_SILENCE = 10.0
"""Longest time [s] until the next frame of a recording that is waited for. Assumed: longer ones are
faults of a file's times, and a node that is silent for longer seems to hang."""
AFTER_FAULT = 0.5
"""Pause [s] after a fault of ours, so that one in each picture does not fill the log. Chosen."""


class CameraNode(ManagedNode[CameraSetup]):
    """Publishes the frames of a source, and its CameraInfo with the same header.

    :param chain: takes each frame before it is published.
    :param on_end: called at the end of a recording if ``exit_at_end`` is set, with the exit status:
        1 if parts of it could not be read.
    """

    def __init__(
        self,
        chain: 'ColorChain | None' = None,
        on_end: Callable[[int], object] = lambda _: None,
        **options: Any,
    ) -> None:
        super().__init__('camera', CameraSetup, **options)
        self._chain, self._on_end = chain, on_end
        self._going, self._paused = threading.Event(), False

    def configure(self) -> None:
        """Open the source, and create the publishers and services."""
        try:
            self._grabber = open_first(self.setup.source, self._open)
        except SourceError as error:
            raise StartError(str(error)) from error
        self._closing = threading.Event()
        self._reopening = Reopening(self._open, self.get_logger().error, self._closing)
        self._state = 'playing'
        self._trouble = ''
        self.health = Health(
            self,
            lambda: self._trouble,
            source=lambda: self._state,
            skipped=lambda: self._grabber.skipped,
            lost=lambda: self._grabber.lost,
            failures=lambda: self._reopening.failures,
        )
        self._images = publish_on(self, Image, self.setup.image_topic)
        self._infos = publish_on(self, CameraInfo, self.setup.camera_info_topic)
        self._calibration = CalibrationServer(
            self, self.setup.camera_info_url, self.setup.camera_info_topic
        )
        # Next to the image topic, wherever it is remapped to.
        self._jpegs = publish_on(self, CompressedImage, f'{self._images.topic_name}/compressed')
        self._answers: Subscription | None = None
        self._window = Window(IN_FLIGHT)
        self._listen(self.setup)
        self._going.clear()
        offer(self, SetBool, '~/pause', self._pause)
        self._hurry = threading.Event()
        self._pacer = Pacer(self._hurry.wait)
        self._base: int | None = None
        self._paced: int | None = None
        self._thread = threading.Thread(target=self._play, name='camera')
        self._thread.start()

    def set_active(self, active: bool) -> None:
        """Publish, or hold a recording and drop a device's pictures."""
        if active and not self._paused:
            self._going.set()
        else:
            self._going.clear()

    def _open(self) -> Grabber:
        source = open_source(
            self.setup.source,
            max(self.setup.rate, 0.0),
            lambda: self.get_clock().now().nanoseconds,
        )
        if isinstance(source, DeviceSource):
            for refusal in source.configure(self.setup.device):
                self.get_logger().warning(refusal)
        return Grabber(source, loop=lambda: self.setup.loop)

    def apply(self, setup: CameraSetup) -> None:
        """Apply changed parameters."""
        self._calibration.load(setup.camera_info_url)
        self._listen(setup)
        if setup.rate != self.setup.rate:  # which may have been one picture in a minute
            self._pacer.restart()
            self._hurry.set()

    def _listen(self, setup: CameraSetup) -> None:
        """Subscribe to the detections that report consumed frames, if they set the pace."""
        if setup.as_consumed and self._chain is None and self._answers is None:
            self._answers = subscribe_to(
                self, PointCloud2, setup.detections_topic, self._take_answer, self.health.refuse
            )

    def _take_answer(self, cdr: bytes) -> None:
        self._window.answer(detections_of_serialized_cloud(cdr).stamp)

    def _play(self) -> None:
        await_clock(self, self._closing.wait)  # stamps from 0 on fit no odometry and no TF
        self._await_subscribers()
        while not self._closing.is_set():
            try:
                if not self._play_next():
                    break
            except Exception as error:  # of any kind: the pictures after it are published
                self.tell_fault(error)
                self._closing.wait(AFTER_FAULT)
        self._end()

    def _play_next(self) -> bool:
        """Publish the next frame, when it is due; return whether there may be more."""
        try:
            frame = self._grabber.read()
        except SourceError as error:
            if self._grabber.live:
                self._recover(error)
            else:
                self.health.refuse(str(error))
            return True
        if frame is None:
            return False
        self._reopening.failures = 0
        self._state, self._trouble = 'playing', ''
        if not self._is_held():
            stamped = self._stamped(frame)
            self._pace(stamped.stamp)
            self._hurry.clear()
            self._publish(stamped)
        return True

    def _pause(self, request: SetBool.Request) -> str:
        self._paused = request.data
        self.set_active(self.active)
        return 'paused' if request.data else 'playing'

    def _is_held(self) -> bool:
        """Wait while a recording is paused; return whether to drop this frame."""
        if self._grabber.live:
            return not self._going.is_set()
        if not self._going.is_set() and self._base is not None:
            paused = Elapsed(self)
            self._going.wait()
            self._base += round(paused() * NANOSECONDS)
        self._going.wait()
        return self._closing.is_set()

    def _await_subscribers(self) -> None:
        wanted = self.setup.wait_for_subscribers
        while wanted and not self._closing.wait(0.02):
            listening = self._images.get_subscription_count() >= wanted
            if listening and (self._answers is None or self._is_answered()):
                self._closing.wait(ACQUAINTANCE)
                return

    def _is_answered(self) -> bool:
        """Whether a node is there that reports consumed frames."""
        return self._answers is not None and self.count_publishers(self._answers.topic_name) > 0

    def _pace(self, stamp: int) -> None:
        """Wait until a frame is due: that of a recording when its stamp says."""
        last, self._paced = self._paced, stamp
        if self.setup.as_consumed:
            if self._is_answered():
                self._window.send(stamp)
        elif self.setup.rate > 0.0:
            self._pacer.pace(1.0 / self.setup.rate)
        elif not self._grabber.live:
            gap = (stamp - last) / NANOSECONDS if last is not None else 0.0
            if gap > MOST_SILENCE:
                self.get_logger().warning(
                    f'the next picture is {gap:.0f} s later: it is published after '
                    f'{MOST_SILENCE:g} s'
                )
            self._pacer.pace(min(gap, MOST_SILENCE))

    def _stamped(self, frame: Frame) -> Frame:
        """Set the stamp of a frame; those of a recording count from the start of playback."""
        if self._base is None:
            self._base = 0 if self._grabber.live else self.get_clock().now().nanoseconds
        return dataclasses.replace(
            frame, stamp=self._base + frame.stamp, frame_id=self.setup.frame_id
        )

    def _publish(self, frame: Frame) -> None:
        self.health.took_in()
        if self._chain:
            self._chain.put(frame)  # before the pictures are sent, which takes longer
            if self.setup.as_consumed:
                self._chain.settle()
        self._infos.publish(self._calibration.beside(frame))
        # A picture is a megabyte or more: converted to a message only for subscribers.
        if self._images.get_subscription_count() > 0:
            self._images.publish(image_of_frame(frame))
        if self._jpegs.get_subscription_count() > 0:
            self._publish_jpeg(frame)
        self.health.gave_out(frame.stamp)

    def _publish_jpeg(self, frame: Frame) -> None:
        try:
            jpeg = compressed_of_frame(frame, self.setup.jpeg_quality)
        except MessageError as error:
            self.health.refuse(str(error))
        else:
            self._jpegs.publish(jpeg)

    def _recover(self, error: SourceError) -> None:
        """Reopen a live source."""
        self._state, self._trouble = 'failed', str(error)
        if grabber := self._reopening.again(error):
            failed, self._grabber = self._grabber, grabber
            failed.close()

    def _end(self) -> None:
        if self._closing.is_set():
            return
        self._state = 'ended'
        lost = self._grabber.lost
        self.get_logger().log(
            f'{self.get_parameter("source").value} has ended: no more frames are published.'
            + (f' {lost} pictures were lost, the file is damaged.' if lost else ''),
            LoggingSeverity.WARN if lost else LoggingSeverity.INFO,
        )
        if self._chain:
            self._chain.flush()
        if self.setup.exit_at_end:
            self._window.drain()
            self._on_end(1 if lost else 0)

    def release(self) -> None:
        """Stop the threads and close the source."""
        self._closing.set()
        self._hurry.set()
        self._going.set()
        self._grabber.close()
        self._thread.join()


def main() -> int:
    """Run the node."""
    return run(lambda stop: [CameraNode(on_end=stop)])
