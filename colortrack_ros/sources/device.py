"""Cameras connected to this machine."""

from dataclasses import dataclass
import glob
import math
from pathlib import Path
from typing import Any
from typing import NoReturn

import cv2
from numpy.typing import NDArray

from colortrack_ros.data import Frame
from colortrack_ros.encodings import LAYOUTS
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import parameter
from colortrack_ros.sources.base import Source
from colortrack_ros.sources.base import SourceError
from colortrack_ros.sources.capture import LiveCapture
from colortrack_ros.sources.capture import Now

ENCODINGS_OF = {
    'YUYV': 'yuyv',
    'UYVY': 'uyvy',
    'NV12': 'nv12',
    'NV21': 'nv21',
    'GREY': 'mono8',
    'RGGB': 'bayer_rggb8',
    'BA81': 'bayer_bggr8',
    'GBRG': 'bayer_gbrg8',
    'GRBG': 'bayer_grbg8',
}
"""Encodings of the Video4Linux pixel formats (FourCC) that are published without conversion."""

AUTO_EXPOSURE, MANUAL_EXPOSURE = 3, 1
"""Values of V4L2_CID_EXPOSURE_AUTO: automatic with a fixed iris, as in all USB cameras, and
manual."""

EXPOSURE_UNIT = 0.1
"""Unit of V4L2_CID_EXPOSURE_ABSOLUTE [ms]: 100 us (Linux kernel, camera control reference)."""


def _four_letters(name: str) -> None:
    if len(name) not in (0, 4):
        raise ValueError(f'expected four letters such as YUYV or MJPG, got {name!r}')


def _control(text: str, unit: str = '', maximum: float = 1e6) -> Any:
    """A field for a camera control that is set here or left to the device."""
    return parameter(
        -1.0,
        f'Of a device: {text} -1 leaves it as it is.',
        unit=unit,
        limits=(-1.0, maximum),
        read_only=True,
    )


@dataclass(frozen=True)
class DeviceConfig(Config):
    """Requested device settings; the node warns about those that the device rejects."""

    width: int = parameter(
        0,
        'Of a device: width of the pictures; 0 leaves it as it is.',
        unit='px',
        limits=(0, 65535),
        read_only=True,
    )
    height: int = parameter(
        0,
        'Of a device: height of the pictures; 0 leaves it as it is.',
        unit='px',
        limits=(0, 65535),
        read_only=True,
    )
    pixel_format: str = parameter(
        '',
        'Of a device: the FourCC of its pixel format, such as YUYV or MJPG; empty leaves it as it '
        'is.',
        valid=_four_letters,
        read_only=True,
    )
    encoding: str = parameter(
        'bgr8',
        "Encoding of the images: converted to bgr8, or the device's own (YUV, Bayer, gray), which "
        'has fewer bytes.',
        choices=('bgr8', 'device'),
        read_only=True,
    )
    exposure: float = _control('exposure time; 0 is automatic,', 'ms')
    gain: float = _control('gain, in its own units;')
    white_balance: float = _control('color temperature of what is white; 0 is automatic,', 'K')
    focus: float = _control('focus, in its own units; 0 is automatic,')


class AbsentSource(Source):
    """Stands in for a missing device: reading raises the error from opening it.

    :param error: raised by opening the device.
    """

    live = True
    period = 0

    def __init__(self, error: SourceError) -> None:
        self._error = error

    @staticmethod
    def accepts(spec: str) -> bool:
        """Accept no spec: this class only replaces a device."""
        return False

    def read(self) -> NoReturn:
        """Raise the error."""
        raise self._error

    def rewind(self) -> None:
        """Do nothing: there is nothing to rewind."""

    def close(self) -> None:
        """Do nothing: nothing is open."""


class DeviceSource(LiveCapture):
    """A camera, given by number or path, `0` or `/dev/video0`.

    :param rate: frames per second to request from the device; 0: its default [Hz].
    :raises SourceError: if there is no such device, or it delivers no pictures.
    """

    def __init__(self, spec: str, rate: float, clock: Now) -> None:
        path = f'/dev/video{spec}' if spec.isdecimal() else spec
        there = ', '.join(sorted(glob.glob('/dev/video*'))) or 'no /dev/video*'
        if not Path(path).exists():
            raise SourceError(f'source {spec!r}: there is no device {path}; there is {there}')
        capture = cv2.VideoCapture(path, cv2.CAP_V4L2)
        if not capture.isOpened():
            raise SourceError(
                f'source {spec!r}: {path} cannot be opened as a camera (in use by another program, '
                f'or no permission?); there is {there}'
            )
        self._rate, self._encoding = rate, 'bgr8'
        super().__init__(capture, f'source {spec!r}: the device', clock)

    def configure(self, config: DeviceConfig) -> list[str]:
        """Request the configured settings from the device, the format first.

        :return: the rejected ones, one line each.
        """
        self._refusals: list[str] = []
        if config.pixel_format:
            self._ask('pixel_format', cv2.CAP_PROP_FOURCC, _code_of(config.pixel_format))
        if config.width:
            self._ask('width', cv2.CAP_PROP_FRAME_WIDTH, config.width)
        if config.height:
            self._ask('height', cv2.CAP_PROP_FRAME_HEIGHT, config.height)
        if self._rate > 0:
            self._ask('rate', cv2.CAP_PROP_FPS, self._rate)
        self._control(config)
        if config.encoding == 'device':
            self._give_own_encoding()
        return self._refusals

    def _control(self, config: DeviceConfig) -> None:
        if config.exposure >= 0:
            mode = MANUAL_EXPOSURE if config.exposure else AUTO_EXPOSURE
            self._ask('exposure', cv2.CAP_PROP_AUTO_EXPOSURE, mode)
        if config.exposure > 0:
            self._ask('exposure', cv2.CAP_PROP_EXPOSURE, round(config.exposure / EXPOSURE_UNIT))
        if config.gain >= 0:
            self._ask('gain', cv2.CAP_PROP_GAIN, config.gain)
        for name, automatic, value in (
            ('white_balance', cv2.CAP_PROP_AUTO_WB, cv2.CAP_PROP_WB_TEMPERATURE),
            ('focus', cv2.CAP_PROP_AUTOFOCUS, cv2.CAP_PROP_FOCUS),
        ):
            wanted = getattr(config, name)
            if wanted >= 0:
                self._ask(name, automatic, float(wanted == 0))
            if wanted > 0:
                self._ask(name, value, wanted)

    def _ask(self, name: str, which: int, value: float) -> None:
        taken = self._capture.set(which, value)
        now = self._capture.get(which)
        if not taken:
            self._refusals.append(f'{name}: the device cannot be told')
        elif now != value:
            is_format = which == cv2.CAP_PROP_FOURCC
            asked, got = (_letters_of(int(v)) if is_format else f'{v:g}' for v in (value, now))
            self._refusals.append(f'{name}: the device does not take {asked}, it has {got}')

    def _give_own_encoding(self) -> None:
        letters = _letters_of(int(self._capture.get(cv2.CAP_PROP_FOURCC)))
        if letters in ENCODINGS_OF and self._capture.set(cv2.CAP_PROP_CONVERT_RGB, 0):
            self._encoding = ENCODINGS_OF[letters]
        else:
            self._refusals.append(
                f'encoding: the device has {letters}, which is published as bgr8; '
                f'pixel_format can be one of {", ".join(ENCODINGS_OF)}'
            )

    def _frame(self, image: NDArray, stamp: int) -> Frame:
        if self._encoding != 'bgr8':
            size = (cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FRAME_WIDTH)
            height, width = (int(self._capture.get(which)) for which in size)
            shape = LAYOUTS[self._encoding].shape(height, width)
            if image.size != math.prod(shape):
                raise SourceError(
                    f'{self._label} gave {image.size} bytes, expected {math.prod(shape)}, '
                    f'{width}x{height} {self._encoding}'
                )
            image = image.reshape(shape)
        return Frame(image, self._encoding, stamp)

    @staticmethod
    def accepts(spec: str) -> bool:
        """Accept a number or a path below /dev."""
        return spec.isdecimal() or spec.startswith('/dev/')


def _code_of(letters: str) -> int:
    return cv2.VideoWriter.fourcc(*letters)


def _letters_of(code: int) -> str:
    return code.to_bytes(4, 'little').decode('ascii', 'replace')
