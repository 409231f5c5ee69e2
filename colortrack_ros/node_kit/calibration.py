"""The calibration of a camera: read from a file, set by a service, published with each frame."""

from rclpy.node import Node
from sensor_msgs.msg import CameraInfo
from sensor_msgs.srv import SetCameraInfo

from colortrack_ros.data import Frame
from colortrack_ros.encodings import size_of
from colortrack_ros.messages import camera_info_of_frame
from colortrack_ros.messages import load_camera_info
from colortrack_ros.messages import save_camera_info


class CalibrationServer:
    """The CameraInfo of a camera, and the service that sets it.

    cameracalibrator calls ``set_camera_info`` in the namespace of the topic; it stores the
    calibration in the file of camera_info_url.

    :param node: the camera.
    :param url: of the file, empty for none.
    :param topic: of the CameraInfo.
    """

    def __init__(self, node: Node, url: str, topic: str) -> None:
        self._node, self._warned = node, False
        self.load(url)
        name = '/'.join([*topic.split('/')[:-1], 'set_camera_info'])
        node.create_service(SetCameraInfo, name, self._set)

    def load(self, url: str) -> None:
        """Read the file.

        :raises ValueError: it cannot be read.
        """
        self._info, self._url, self._warned = load_camera_info(url), url, False

    def beside(self, frame: Frame) -> CameraInfo:
        """The CameraInfo of a frame; warns once if the calibration is for another size."""
        info = camera_info_of_frame(frame, self._info)
        height, width = size_of(frame)
        if (info.width, info.height) != (width, height) and not self._warned:
            self._warned = True
            self._node.get_logger().warning(
                f'camera_info_url: {self._url} is the calibration of {info.width}x{info.height} '
                f'pictures, these have {width}x{height}; calibrate anew for this size'
            )
        return info

    def _set(
        self, request: SetCameraInfo.Request, response: SetCameraInfo.Response
    ) -> SetCameraInfo.Response:
        try:
            save_camera_info(self._url, request.camera_info)
            self.load(self._url)
        except ValueError as error:
            response.status_message = f'camera_info_url: {error}'
            return response
        response.success = True
        response.status_message = f'stored in {self._url}'
        return response
