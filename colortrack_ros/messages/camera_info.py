"""YAML of camera_calibration -> sensor_msgs/CameraInfo -> picture size."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ament_index_python.packages import get_package_share_directory
from ament_index_python.packages import PackageNotFoundError
from sensor_msgs.msg import CameraInfo
import yaml

from colortrack_ros.data import Frame
from colortrack_ros.encodings import size_of
from colortrack_ros.files import read_file
from colortrack_ros.files import write_file
from colortrack_ros.messages.errors import MessageError
from colortrack_ros.messages.header import header_of
from colortrack_ros.messages.serialized import message_of_serialized

MAX_CALIBRATION = 1 << 16
"""Maximum size of a calibration file [bytes]: thirty times what camera_calibration writes, and half
a second of YAML parsing."""

_MATRICES = {
    'k': ('camera_matrix', 9),
    'd': ('distortion_coefficients', None),
    'r': ('rectification_matrix', 9),
    'p': ('projection_matrix', 12),
}


def load_camera_info(url: str) -> CameraInfo:
    """The calibration in a file; all zeros, which means uncalibrated, for an empty URL.

    :param url: ``file:///path``, ``package://name/path`` or a plain path.
    :raises ValueError: there is no such file, or it is not a calibration; the reason says which.
    """
    if not url:
        return CameraInfo()
    path = _path(url)
    content = read_file(path, MAX_CALIBRATION)
    try:
        calibration = yaml.safe_load(content)
        info = CameraInfo(
            width=_size(calibration, 'image_width'),
            height=_size(calibration, 'image_height'),
            # as camera_info_manager, for files of before there were others
            distortion_model=str(calibration.get('distortion_model', 'plumb_bob')),
        )
        for field, (key, count) in _MATRICES.items():
            data = [float(value) for value in calibration[key]['data']]
            if count is not None and len(data) != count:
                raise ValueError(f'{key} has {len(data)} numbers, expected {count}')
            setattr(info, field, data)
    except Exception as error:  # a file of 20,000 brackets raises RecursionError
        what = f'no {error.args[0]}' if isinstance(error, KeyError) else str(error)
        raise ValueError(
            f'{path} is not a calibration as camera_calibration writes it: '
            f'{" ".join(what.split()) or type(error).__name__}'
        ) from error
    return info


def save_camera_info(url: str, info: CameraInfo) -> None:
    """Write a calibration as camera_calibration does; :func:`load_camera_info` reads it.

    On failure the old file is unchanged.

    :raises ValueError: there is no URL, it cannot be written to, or the calibration is too large.
    """
    if not url:
        raise ValueError('expected the path of a file to store the calibration in, got none')
    columns = {'k': 3, 'r': 3, 'p': 4}
    content: dict[str, object] = {
        'image_width': info.width,
        'image_height': info.height,
        'camera_name': 'camera',
        'distortion_model': info.distortion_model,
    }
    for field, (key, _) in _MATRICES.items():
        data = [float(value) for value in getattr(info, field)]
        width = columns.get(field, len(data))
        content[key] = {'rows': len(data) // max(width, 1), 'cols': width, 'data': data}
    path, text = _path(url), yaml.safe_dump(content, sort_keys=False).encode()
    if len(text) > MAX_CALIBRATION:
        raise ValueError(
            f'expected a calibration of at most {MAX_CALIBRATION} bytes, got {len(text)}'
        )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_file(path, text)
    except OSError as error:
        raise ValueError(f'{error.strerror}: {path}') from error


def camera_info_of_frame(frame: Frame, info: CameraInfo) -> CameraInfo:
    """Complete the CameraInfo of a frame: header, and size if the camera is not calibrated.

    :param info: the calibration, modified in place and returned.
    """
    info.header = header_of(frame.stamp, frame.frame_id)
    if not info.k[0]:
        info.height, info.width = size_of(frame)
    return info


def image_size_of_serialized_camera_info(cdr: bytes) -> tuple[int, int]:
    """Width and height of the pictures that a serialized CameraInfo describes [px].

    :raises MessageError: these are not the bytes of a CameraInfo, or one of the two is zero.
    """
    return image_size_of_camera_info(message_of_serialized(cdr, CameraInfo))


def image_size_of_camera_info(info: CameraInfo) -> tuple[int, int]:
    """Width and height of the pictures that a CameraInfo describes [px].

    They are those of its region of interest, if it has one, after binning.

    :return: zeros if the message gives none.
    :raises MessageError: one of the two is zero.
    """
    width, height = info.roi.width or info.width, info.roi.height or info.height
    if bool(width) != bool(height):
        raise MessageError(f'CameraInfo: expected a width and a height, got {width} x {height}')
    return width // max(info.binning_x, 1), height // max(info.binning_y, 1)


def _size(calibration: Mapping[str, Any], key: str) -> int:
    size = int(calibration[key])
    if not 0 <= size < 1 << 32:  # or publishing it would raise
        raise ValueError(f'{key}: expected the width or height of a picture, got {size}')
    return size


def _path(url: str) -> Path:
    if url.startswith('package://'):
        package, _, inside = url.removeprefix('package://').partition('/')
        try:
            return Path(get_package_share_directory(package)) / inside
        except (PackageNotFoundError, OSError, ValueError) as error:
            raise ValueError(f'{url}: there is no package {package!r}') from error
    path = Path(url.removeprefix('file://'))
    try:
        return path.expanduser()
    except RuntimeError as error:
        raise ValueError(f'{path}: there is no such user, whose folder this would be') from error
