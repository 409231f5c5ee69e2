from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Image
from std_msgs.msg import Header

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.encodings import LAYOUTS
from colortrack_ros.messages import frame_of_image
from colortrack_ros.messages import frame_of_serialized_image
from colortrack_ros.messages import image_of_frame
from colortrack_ros.messages import MessageError
from colortrack_ros.messages import stamp_of
from colortrack_ros.messages import stamp_of_serialized

TEXT = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=9)


@st.composite
def frames(draw):
    encoding = draw(st.sampled_from(sorted(LAYOUTS)))
    wide, high = LAYOUTS[encoding].even
    shape = LAYOUTS[encoding].shape(high * draw(st.integers(0, 5)), wide * draw(st.integers(0, 5)))
    pixels = np.random.default_rng(draw(st.integers(0, 99))).integers(0, 256, shape, np.uint8)
    stamp = draw(st.integers(-(2**31) * 10**9, 2**31 * 10**9 - 1))
    return Frame(pixels, encoding, stamp, draw(TEXT))


@pytest.mark.slow
@given(frames())
def test_a_frame_comes_back_from_its_message(frame):
    message = image_of_frame(frame)
    for back in (frame_of_image(message), frame_of_serialized_image(serialize_message(message))):
        np.testing.assert_array_equal(back.image, frame.image)
        assert back.image.shape == frame.image.shape
        assert (back.encoding, back.stamp, back.frame_id) == (
            frame.encoding,
            frame.stamp,
            frame.frame_id,
        )


@pytest.mark.slow
@given(frames(), st.integers(1, 7))
def test_padded_rows_are_viewed_without_their_padding(frame, padding):
    message = image_of_frame(frame)
    rows = np.asarray(message.data, np.uint8).reshape(len(frame.image), message.step)
    message.step += padding
    message.data = np.pad(rows, ((0, 0), (0, padding)), constant_values=255).tobytes()
    np.testing.assert_array_equal(frame_of_image(message).image, frame.image)


def image(**changes):
    message = Image(height=4, width=5, encoding='bgr8', step=15, data=bytes(60))
    for name, value in changes.items():
        setattr(message, name, value)
    return message


@pytest.mark.parametrize(
    ('changes', 'reason'),
    [
        ({'data': bytes(59)}, 'image data of 59 bytes: expected 60, 4 rows of 15 bytes (5x4 bgr8)'),
        ({'data': bytes(61)}, 'image data of 61 bytes'),
        ({'step': 14}, 'image step 14: expected at least 15'),
        ({'step': 4000}, 'image data of 60 bytes: expected 16000'),
        ({'width': 6}, 'image step 15: expected at least 18'),
        ({'height': 5}, 'image data of 60 bytes: expected 75'),
        ({'encoding': '32FC1'}, "image encoding '32FC1': expected one of bgr8, rgb8"),
        ({'encoding': 'yuyv'}, 'image of 5x4 yuyv: expected a width that is a multiple of 2'),
        ({'encoding': 'nv12', 'width': 4, 'height': 5}, 'a height that is one of 2'),
        (
            {'encoding': 'nv21', 'width': 4},
            'image data of 60 bytes: expected 90, 6 rows of 15 bytes',
        ),
        ({'encoding': 'mono16', 'step': 9}, 'image step 9: expected at least 10'),
        ({'encoding': ''}, "image encoding ''"),
    ],
)
def test_an_image_that_contradicts_itself_is_refused_with_a_reason(changes, reason):
    for read in (frame_of_image, lambda m: frame_of_serialized_image(serialize_message(m))):
        with pytest.raises(MessageError) as refusal:
            read(image(**changes))
        assert reason in str(refusal.value)


@pytest.mark.parametrize(
    ('name', 'encoding', 'channels'),
    [
        ('8UC1', 'mono8', 1), ('8UC3', 'bgr8', 3), ('8UC4', 'bgra8', 4), ('yuv422', 'uyvy', 2),
        ('yuv422_yuy2', 'yuyv', 2),
    ],
)  # fmt: skip
def test_older_and_other_names_of_an_encoding_mean_the_same(name, encoding, channels):
    data = bytes(range(8 * channels))
    message = Image(height=2, width=4, encoding=name, step=4 * channels, data=data)
    frame = frame_of_image(message)
    assert frame.encoding == encoding
    assert frame.image.tobytes() == data


@pytest.mark.parametrize('name', ['mono16', 'bayer_rggb16', 'bayer_grbg16'])
@pytest.mark.parametrize('big_endian', [False, True])
@pytest.mark.parametrize('padding', [0, 3])
def test_of_sixteen_bits_the_upper_eight_are_taken(name, big_endian, padding):
    values = np.arange(8).reshape(2, 4) * 8000 + 77
    rows = values.astype('>u2' if big_endian else '<u2').view(np.uint8)
    message = Image(height=2, width=4, encoding=name, step=8 + padding, is_bigendian=big_endian)
    message.data = np.pad(rows, ((0, 0), (0, padding)), constant_values=255).tobytes()
    for read in (frame_of_image, lambda m: frame_of_serialized_image(serialize_message(m))):
        frame = read(message)
        assert frame.encoding == name.replace('16', '8')
        np.testing.assert_array_equal(frame.image, values // 256)


@pytest.mark.parametrize(
    ('name', 'encoding'),
    [
        ('rgb16', 'rgb8'), ('bgr16', 'bgr8'), ('rgba16', 'rgba8'), ('bgra16', 'bgra8'),
        ('16UC3', 'bgr8'), ('16UC4', 'bgra8'),
    ],
)  # fmt: skip
@pytest.mark.parametrize('big_endian', [False, True])
@pytest.mark.parametrize('padding', [0, 5])
def test_of_sixteen_bits_of_color_the_upper_eight_are_taken(name, encoding, big_endian, padding):
    channels = ENCODINGS[encoding]
    values = (np.arange(15 * channels).reshape(5, 3, channels) * 1000 + 77) % 65536
    rows = values.astype('>u2' if big_endian else '<u2').view(np.uint8).reshape(5, -1)
    message = Image(height=5, width=3, encoding=name, is_bigendian=big_endian)
    message.step = 6 * channels + padding
    message.data = np.pad(rows, ((0, 0), (0, padding)), constant_values=255).tobytes()
    frame = frame_of_image(message)
    assert frame.encoding == encoding
    np.testing.assert_array_equal(frame.image, values // 256)


@pytest.mark.slow
@given(st.data())
def test_mutated_bytes_are_refused_or_read_but_never_raise_anything_else(data):
    cdr = bytearray(serialize_message(image()))
    for _ in range(data.draw(st.integers(1, 8))):
        cdr[data.draw(st.integers(0, len(cdr) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(cdr)))
    for mutated in (bytes(cdr), bytes(cdr[:cut])):
        try:
            frame = frame_of_serialized_image(mutated)
        except MessageError:
            continue
        assert frame.image.base is not None


@pytest.mark.parametrize('nanosec', [10**9, 2**32 - 1])
def test_a_stamp_of_a_second_or_more_of_nanoseconds_is_refused(nanosec):
    header = Header()
    header.stamp.nanosec = nanosec
    with pytest.raises(MessageError, match='expected less than a second'):
        stamp_of(header)
    with pytest.raises(MessageError, match='not a serialized message with a header'):
        stamp_of_serialized(serialize_message(header))


@pytest.mark.parametrize('cdr', [b'', b'\0\1\0\0', b'\0\2\0\0' + bytes(8)])
def test_bytes_without_a_stamp_are_refused(cdr):
    with pytest.raises(MessageError, match='not a serialized message with a header'):
        stamp_of_serialized(cdr)


def test_the_pixels_of_a_message_cannot_be_written():
    message = Image(height=2, width=1, encoding='bgr8', step=4, data=bytes(8))
    assert not frame_of_image(message).image.flags.writeable
