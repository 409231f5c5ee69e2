from typing import ClassVar

import cv2
import numpy as np
import pytest
from support.cameras import encode

from colortrack_ros.encodings import LAYOUTS
from colortrack_ros.sources import device
from colortrack_ros.sources import SourceError
from colortrack_ros.sources.device import DeviceConfig
from colortrack_ros.sources.device import DeviceSource
from colortrack_ros.sources.device import ENCODINGS_OF

PICTURE = np.random.default_rng(2).integers(0, 256, (8, 12, 3), dtype=np.uint8)


class FakeDevice:
    """A capture of Video4Linux with a few controls, which writes down what it is asked for.

    It gives pictures as OpenCV does: as bgr8, or with CONVERT_RGB off as the bytes it has.
    """

    made: ClassVar[list['FakeDevice']] = []
    fixed: ClassVar[dict[int, float]] = {
        cv2.CAP_PROP_FRAME_WIDTH: 12.0,
        cv2.CAP_PROP_FRAME_HEIGHT: 8.0,
    }

    def __init__(self, *_):
        self.asked = {}
        self.values = {cv2.CAP_PROP_FOURCC: float(cv2.VideoWriter.fourcc(*'YUYV'))}
        FakeDevice.made.append(self)

    def isOpened(self):
        return True

    def get(self, which):
        return self.fixed.get(which, self.values.get(which, 0.0))

    def set(self, which, value):
        self.asked[which] = value
        self.values[which] = float(value)
        return which not in (cv2.CAP_PROP_FOCUS, cv2.CAP_PROP_AUTOFOCUS)

    def grab(self):
        return True

    def retrieve(self):
        letters = int(self.values[cv2.CAP_PROP_FOURCC]).to_bytes(4, 'little').decode()
        if self.values.get(cv2.CAP_PROP_CONVERT_RGB, 1):
            return True, PICTURE.copy()
        image = encode(PICTURE, ENCODINGS_OF[letters]).image
        return True, image if letters in ('YUYV', 'UYVY') else image.reshape(1, -1)


@pytest.fixture
def source(tmp_path, monkeypatch):
    monkeypatch.setattr(device.cv2, 'VideoCapture', FakeDevice)
    monkeypatch.setattr(device.Path, 'exists', lambda _: True)
    return DeviceSource('/dev/video0', 25.0, lambda: 7)


def test_a_device_that_nobody_configures_is_left_as_it_is(source):
    assert source.configure(DeviceConfig()) == []
    assert FakeDevice.made[-1].asked == {cv2.CAP_PROP_FPS: 25.0}
    assert source.read().encoding == 'bgr8'


def test_fixed_values_are_set_after_the_automatic_is_off(source):
    config = DeviceConfig(pixel_format='UYVY', exposure=8.0, gain=3.0, white_balance=4600.0)
    assert source.configure(config) == []
    asked = FakeDevice.made[-1].asked
    assert list(asked) == [
        cv2.CAP_PROP_FOURCC, cv2.CAP_PROP_FPS, cv2.CAP_PROP_AUTO_EXPOSURE, cv2.CAP_PROP_EXPOSURE,
        cv2.CAP_PROP_GAIN, cv2.CAP_PROP_AUTO_WB, cv2.CAP_PROP_WB_TEMPERATURE,
    ]  # fmt: skip
    assert asked[cv2.CAP_PROP_AUTO_EXPOSURE] == 1
    assert asked[cv2.CAP_PROP_EXPOSURE] == 80  # of 0.1 ms
    assert (asked[cv2.CAP_PROP_AUTO_WB], asked[cv2.CAP_PROP_WB_TEMPERATURE]) == (0, 4600)


def test_zero_switches_the_automatic_on(source):
    source.configure(DeviceConfig(exposure=0.0, white_balance=0.0))
    asked = FakeDevice.made[-1].asked
    assert (asked[cv2.CAP_PROP_AUTO_EXPOSURE], asked[cv2.CAP_PROP_AUTO_WB]) == (3, 1)
    assert cv2.CAP_PROP_EXPOSURE not in asked


def test_what_the_device_does_not_take_is_told(source):
    refused = source.configure(DeviceConfig(width=1920, height=8, focus=30.0))
    assert refused == [
        'width: the device does not take 1920, it has 12',
        'focus: the device cannot be told',
        'focus: the device cannot be told',
    ]


@pytest.mark.parametrize('letters', ENCODINGS_OF)
def test_a_device_gives_its_own_encoding_when_asked(source, letters):
    assert source.configure(DeviceConfig(pixel_format=letters, encoding='device')) == []
    frame, encoding = source.read(), ENCODINGS_OF[letters]
    assert frame.encoding == encoding
    assert frame.image.shape == LAYOUTS[encoding].shape(8, 12)
    np.testing.assert_array_equal(frame.image, encode(PICTURE, encoding).image)


def test_a_picture_of_too_few_bytes_is_not_taken(source, monkeypatch):
    source.configure(DeviceConfig(encoding='device'))
    monkeypatch.setattr(FakeDevice, 'retrieve', lambda _: (True, np.zeros((1, 100), np.uint8)))
    with pytest.raises(SourceError, match='gave 100 bytes, expected 192, 12x8 yuyv'):
        source.read()


def test_a_format_without_an_encoding_is_published_as_bgr8_and_told(source):
    (refused,) = source.configure(DeviceConfig(pixel_format='MJPG', encoding='device'))
    assert refused.startswith('encoding: the device has MJPG, which is published as bgr8')
    assert source.read().encoding == 'bgr8'
