"""Passes detections to the tracker; if asked to, it waits for their viewpoint first."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from rclpy.node import Node

from colortrack_ros.data import Detections
from colortrack_ros.data import Tracks
from colortrack_ros.flow.completion import Completion
from colortrack_ros.flow.stage import Stage
from colortrack_ros.flow.stage import Worker
from colortrack_ros.node_kit.camera_pose import CameraPoseConfig
from colortrack_ros.node_kit.camera_view import CameraViews
from colortrack_ros.node_kit.clocks import seconds_of
from colortrack_ros.world import TransformError
from colortrack_ros.world.view import JumpWatch
from colortrack_ros.world.waiting import LONGEST_WAIT


class ViewpointIntake:
    """Passes detections to a stage, with the camera's viewpoint if that is asked for.

    :param stage: processes them.
    :param refuse: takes the reason if something is wrong.
    """

    def __init__(
        self, node: Node, stage: Stage[Detections, Tracks], refuse: Callable[[str], object]
    ) -> None:
        self._node, self._stage, self._refuse = node, stage, refuse
        self._views: CameraViews | None = None
        self._asked = False
        self._watch = JumpWatch()
        self._waiting = Completion(self._complete, stage.put, LONGEST_WAIT, seconds_of(node))

    def clear(self) -> None:
        """Forget the subscriptions, which have already been destroyed."""
        self._views, self._asked = None, False

    def configure(self, config: CameraPoseConfig, info_topic: str, *, asked: bool) -> None:
        """Start or stop waiting for viewpoints.

        :param info_topic: of the CameraInfo.
        :raises StartError: they are to come from TF, and tf2_ros is not installed.
        """
        if asked and self._views is None:
            self._views = CameraViews(
                self._node, config, info_topic, self._refuse, self._waiting.look
            )
        if self._views:
            self._views.configure(config)
        self._asked = asked
        self.look()

    def put(self, item: Detections, context: Any = None) -> None:
        """Take the detections of the next picture; the context is passed on."""
        if not self._stage.paused:
            self._waiting.put(item, context)

    def put_unread(self, read: Callable[[], Detections], size: int) -> None:
        """Take the next detections; the stage itself reads them if they need not wait.

        :param read, size: as for :meth:`Worker.put_unread`.
        """
        assert isinstance(self._stage, Worker)
        if self._asked:
            self.put(read())
        else:
            self._stage.put_unread(read, size)

    def look(self) -> None:
        """Pass on those whose viewpoint is known, or is overdue."""
        self._waiting.look()

    def flush(self) -> None:
        """Pass on all, and have them processed; the input has ended."""
        self._waiting.flush()
        self._stage.flush()

    def _complete(self, detections: Detections, over: bool) -> Detections | None:
        """The detections with their viewpoint; None while it may still arrive."""
        if not (self._asked and self._views):
            return detections
        try:
            view = self._views.at(detections.stamp, detections.frame_id)
            view = self._watch.checked(detections.stamp, view)
        except TransformError as error:
            if error.later and not over:
                return None
            self._refuse(f'the viewpoint; tracks continue as if the camera stood still: {error}')
            return detections
        return replace(detections, viewpoint=view)
