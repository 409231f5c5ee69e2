import math
import struct

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from support.boxes import box
from support.boxes import serialized

from colortrack_ros.messages import BoxReader
from colortrack_ros.messages import MessageError

TEXT = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=9)
PIXELS = st.floats(-1e5, 1e5)
SIZES = st.floats(0, 1e4)
RESULTS = st.lists(st.tuples(TEXT, st.floats(0, 1)), max_size=4)
BOXES = st.lists(st.builds(box, PIXELS, PIXELS, SIZES, SIZES, RESULTS, name=TEXT), max_size=6)


def read(boxes, classes=(), tell=pytest.fail, least_score=0.0, **options):
    return BoxReader(classes, least_score, tell).read(serialized(boxes, **options))


@given(BOXES, st.integers(0, 2**31 * 10**9 - 1), TEXT, st.booleans())
def test_boxes_of_a_network_are_read_as_they_were_written(boxes, stamp, frame_id, little_endian):
    found = read(boxes, stamp=stamp, frame_id=frame_id, little_endian=little_endian)
    assert (found.stamp, found.frame_id) == (stamp, frame_id)
    rows = found.rows
    assert rows['u'].tolist() == [u for u, *_ in boxes]
    assert rows['v'].tolist() == [v for _, v, *_ in boxes]
    sizes = np.array([one[2:4] for one in boxes], np.float32).reshape(-1, 2)
    np.testing.assert_array_equal(np.stack([rows['box_w'], rows['box_h']], axis=1), sizes)
    middle = rows['box_u'] + (rows['box_w'].astype(float) - 1) / 2
    np.testing.assert_allclose(middle, rows['u'], atol=0.02)
    scores = [max((score for _, score in one[4]), default=1.0) for one in boxes]
    np.testing.assert_array_equal(rows['score'], np.array(scores, np.float32))
    assert not rows['color'].any()
    assert not rows['cov_uu'].any()


def test_a_box_has_its_most_likely_class_and_others_are_left_out_and_told_once():
    told = []
    unsure = box(1.0, 2.0, 9.0, 9.0, [('cup', 0.2), ('ball', 0.7), ('cat', 0.1)])
    reader = BoxReader(['cup', 'ball'], 0.0, told.append)
    boxes = [box(5.0, 5.0, 9.0, 9.0, [('dog', 0.9)]), unsure, box(7.0, 5.0, 9.0, 9.0, [])]
    for _ in range(2):
        rows = reader.read(serialized(boxes)).rows
        assert (rows['u'].tolist(), rows['color'].tolist()) == ([1.0], [1])
        assert rows['score'] == pytest.approx(0.7)
    assert told == [
        "class 'dog' is left out: expected one of ['cup', 'ball']",
        "class '' is left out: expected one of ['cup', 'ball']",
    ]


def test_what_a_network_hardly_believes_is_left_out_and_told_once():
    told = []
    reader = BoxReader([], 0.1, told.append)
    scores = [0.01, 0.8, math.nan, 0.1, 0.099]
    boxes = [box(10.0 * k, 5.0, 9.0, 9.0, [('cup', score)]) for k, score in enumerate(scores)]
    for _ in range(2):
        rows = reader.read(serialized([*boxes, box(90.0, 5.0, 9.0, 9.0, [])])).rows
        assert rows['u'].tolist() == [10.0, 20.0, 30.0, 90.0]
    assert told == ['boxes with scores below 0.1 are left out, see min_box_score']
    (row,) = read([box(1.0, 5.0, 9.0, 9.0, [('cup', -0.3)])], least_score=0.0).rows
    assert row['score'] == pytest.approx(-0.3), 'as those of a DPM: 0 takes all'


def test_a_turned_box_becomes_the_upright_one_around_it():
    rows = read([box(50.0, 60.0, 30.0, 10.0, theta=math.pi / 2)]).rows
    assert (rows['box_w'], rows['box_h'], rows['area']) == pytest.approx((10, 30, 75 * math.pi))
    rows = read([box(50.0, 60.0, 10.0, 10.0, theta=-math.pi / 4)]).rows
    assert rows['box_w'] == rows['box_h'] == pytest.approx(10 * math.sqrt(2))


def test_what_is_no_such_message_is_refused_with_a_reason():
    whole = serialized([box(1.0, 2.0, 3.0, 4.0, name='seven')] * 2, 5)
    reader = BoxReader([], 0.0, pytest.fail)
    for size in range(len(whole)):
        with pytest.raises(MessageError, match='not a serialized vision_msgs/msg/Detection2DArray'):
            reader.read(whole[:size])
    with pytest.raises(MessageError, match='4 bytes more than its fields have'):
        reader.read(whole + bytes(4))
    huge = whole[:8] + b'\xff' * (len(whole) - 8)
    with pytest.raises(MessageError):
        reader.read(huge)


BEFORE = {
    'boxes': serialized([])[:-4],
    'hypotheses': serialized([box(1.0, 2.0, 3.0, 4.0, [])])[: len(serialized([])) + 16],
}
"""The bytes before the number of them."""


@pytest.mark.parametrize('of', BEFORE)
def test_more_than_its_bytes_can_hold_are_not_looked_for(of):
    cdr = BEFORE[of] + struct.pack('<I', 2**32 - 1) + bytes(1000)
    with pytest.raises(MessageError, match='4294967295 elements in 1000 bytes: expected at least'):
        BoxReader([], 0.0, pytest.fail).read(cdr)


def test_of_a_class_without_end_a_line_is_told():
    told = []
    for end in 'ab':
        name = 1_000_000 * 'z' + end
        assert not len(read([box(1.0, 2.0, 3.0, 4.0, [(name, 0.5)])], ['cup'], told.append).rows)
    assert [len(line) < 150 for line in told] == [True, True]


@pytest.mark.parametrize('wrong', [math.nan, math.inf, 1e300])
def test_a_number_that_is_none_reaches_the_tracker_which_refuses_it(wrong):
    rows = read([box(wrong, 2.0, wrong, 4.0, theta=wrong), box(1.0, 2.0, 3.0, 4.0)]).rows
    assert not np.abs(rows['u'][0]) < 1e6
    assert rows['u'][1] == 1.0
    assert rows['box_w'][1] == 3.0


def test_the_message_of_vision_msgs_is_read_as_it_was_written():
    vision = pytest.importorskip(
        'vision_msgs.msg', reason='vision_msgs is in no wheel; a robot has it'
    )
    from rclpy.serialization import serialize_message

    message = vision.Detection2DArray()
    message.header.frame_id, message.header.stamp.sec = 'front', 7
    one = vision.Detection2D(id='3')
    one.bbox.center.position.x, one.bbox.size_x, one.bbox.size_y = 12.5, 8.0, 6.0
    one.results = [vision.ObjectHypothesisWithPose(), vision.ObjectHypothesisWithPose()]
    one.results[1].hypothesis.class_id, one.results[1].hypothesis.score = 'ball', 0.5
    message.detections = [one, one]
    found = BoxReader(['ball'], 0.0, pytest.fail).read(serialize_message(message))
    assert (found.stamp, found.frame_id) == (7 * 10**9, 'front')
    assert found.rows['u'].tolist() == [12.5, 12.5]
    assert found.rows['box_w'].tolist() == [8.0, 8.0]
