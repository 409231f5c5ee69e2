import array

from hypothesis import given
from hypothesis import strategies as st
import numpy as np
import pytest
from rclpy.serialization import serialize_message
from sensor_msgs.msg import PointCloud2

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.data import TRACK
from colortrack_ros.data import Tracks
from colortrack_ros.messages import cloud_of_detections
from colortrack_ros.messages import cloud_of_outlines
from colortrack_ros.messages import cloud_of_tracks
from colortrack_ros.messages import detections_of_cloud
from colortrack_ros.messages import MessageError
from colortrack_ros.messages import outlines_of_serialized_cloud
from colortrack_ros.messages import tracks_of_cloud
from colortrack_ros.messages import tracks_with_outlines

TEXT = st.text(st.characters(codec='utf-8', exclude_characters='\0'), max_size=9)


def random_rows(dtype, count, seed=0):
    rng = np.random.default_rng(seed)
    rows = np.zeros(count, dtype)
    for name in dtype.names:
        rows[name] = rng.integers(0, 200, rows[name].shape)
    return rows


@given(st.integers(0, 50), st.integers(0, 2**31 * 10**9 - 1), TEXT)
def test_rows_come_back_from_their_message(count, stamp, frame_id):
    detections = Detections(random_rows(DETECTION, count), stamp, frame_id)
    back = detections_of_cloud(cloud_of_detections(detections))
    np.testing.assert_array_equal(back.rows, detections.rows)
    assert (back.stamp, back.frame_id) == (stamp, frame_id)
    tracks = Tracks(random_rows(TRACK, count), stamp, frame_id)
    np.testing.assert_array_equal(tracks_of_cloud(cloud_of_tracks(tracks)).rows, tracks.rows)


def test_the_layout_of_tracks_is_that_of_the_contract():
    cloud = cloud_of_tracks(Tracks(random_rows(TRACK, 3)))
    assert (cloud.height, cloud.width, cloud.point_step, cloud.row_step) == (1, 3, 208, 624)
    assert cloud.is_dense
    assert not cloud.is_bigendian
    assert [(f.name, f.offset, f.datatype, f.count) for f in cloud.fields] == [
        ('u', 0, 8, 1),
        ('v', 8, 8, 1),
        ('du', 16, 8, 1),
        ('dv', 24, 8, 1),
        ('covariance', 32, 8, 16),
        ('track_id', 160, 6, 1),
        ('color', 164, 6, 1),
        ('state', 168, 2, 1),
        ('age', 172, 7, 1),
        ('time_since_update', 176, 7, 1),
        ('hits', 180, 6, 1),
        ('area', 184, 7, 1),
        ('box_w', 188, 7, 1),
        ('box_h', 192, 7, 1),
        ('score', 196, 7, 1),
        ('box_u', 200, 7, 1),
        ('box_v', 204, 7, 1),
    ]


def test_the_layout_of_detections_is_that_of_the_contract():
    cloud = cloud_of_detections(Detections(random_rows(DETECTION, 2)))
    assert (cloud.point_step, cloud.row_step) == (72, 144)
    assert [(f.name, f.offset, f.datatype) for f in cloud.fields] == [
        ('u', 0, 8),
        ('v', 8, 8),
        ('cov_uu', 16, 8),
        ('cov_uv', 24, 8),
        ('cov_vv', 32, 8),
        ('area', 40, 7),
        ('box_u', 44, 7),
        ('box_v', 48, 7),
        ('box_w', 52, 7),
        ('box_h', 56, 7),
        ('score', 60, 7),
        ('color', 64, 6),
    ]


def test_another_order_of_fields_and_bytes_is_read_by_name():
    rows = random_rows(DETECTION, 4)
    cloud = cloud_of_detections(Detections(rows))
    moved = np.dtype(
        {
            'names': list(DETECTION.names),
            'formats': [DETECTION.fields[n][0].newbyteorder('>') for n in DETECTION.names],
            'offsets': [DETECTION.fields[n][1] + 5 for n in DETECTION.names],
            'itemsize': 90,
        }
    )
    given_rows = np.zeros(4, moved)
    for name in DETECTION.names:
        given_rows[name] = rows[name]
    cloud.is_bigendian, cloud.point_step, cloud.row_step = True, 90, 360
    cloud.data = given_rows.tobytes()
    fields = cloud_of_detections(Detections()).fields
    cloud.fields = [
        type(f)(name=f.name, offset=f.offset + 5, datatype=f.datatype, count=1)
        for f in reversed(fields)
    ]
    np.testing.assert_array_equal(detections_of_cloud(cloud).rows, rows)


def test_boxes_of_recordings_that_do_not_say_where_they_are_lie_around_the_positions():
    tracks = Tracks(random_rows(TRACK, 3))
    cloud = cloud_of_tracks(tracks)
    cloud.fields = [field for field in cloud.fields if field.name not in ('box_u', 'box_v')]
    rows = tracks_of_cloud(cloud).rows
    np.testing.assert_allclose(rows['box_u'] + (rows['box_w'] - 1) / 2, tracks.rows['u'])
    np.testing.assert_allclose(rows['box_v'] + (rows['box_h'] - 1) / 2, tracks.rows['v'])
    for name in set(TRACK.names) - {'box_u', 'box_v'}:
        np.testing.assert_array_equal(rows[name], tracks.rows[name])


@pytest.mark.parametrize(
    ('change', 'reason'),
    [
        (lambda c: setattr(c, 'width', 3), 'point cloud data of 144 bytes'),
        (lambda c: setattr(c, 'height', 2), 'point cloud of height 2: expected 1'),
        (lambda c: setattr(c, 'data', bytes(143)), 'point cloud data of 143 bytes'),
        (lambda c: setattr(c, 'point_step', 71), 'point cloud data of 144 bytes'),
        (lambda c: setattr(c, 'row_step', 143), 'row_step 143: expected 144'),
        (lambda c: setattr(c, 'fields', c.fields[1:]), "point cloud without the field 'u'"),
        (lambda c: setattr(c, 'fields', []), "point cloud without the field 'u'"),
    ],
)
def test_a_cloud_that_contradicts_itself_is_refused_with_a_reason(change, reason):
    cloud = cloud_of_detections(Detections(random_rows(DETECTION, 2)))
    change(cloud)
    with pytest.raises(MessageError) as refusal:
        detections_of_cloud(cloud)
    assert reason in str(refusal.value)


def test_a_field_of_another_type_or_beyond_the_point_is_refused():
    for name, value, reason in (('datatype', 7, 'expected 8'), ('offset', 70, 'point_step of 72')):
        cloud = cloud_of_detections(Detections(random_rows(DETECTION, 2)))
        copies = [
            type(f)(name=f.name, offset=f.offset, datatype=f.datatype, count=f.count)
            for f in cloud.fields
        ]
        setattr(copies[0], name, value)
        cloud.fields = copies
        with pytest.raises(MessageError, match=reason):
            detections_of_cloud(cloud)


@pytest.mark.parametrize('height', [0, 1])
def test_an_empty_cloud_needs_no_fields(height):
    assert len(detections_of_cloud(PointCloud2(height=height)).rows) == 0


def test_points_may_be_padded_at_their_end():
    rows = random_rows(DETECTION, 3)
    cloud = cloud_of_detections(Detections(rows))
    padded = np.zeros((3, 80), np.uint8)
    padded[:, :72] = rows.view(np.uint8).reshape(3, 72)
    cloud.point_step, cloud.row_step, cloud.data = 80, 240, padded.tobytes()
    np.testing.assert_array_equal(detections_of_cloud(cloud).rows, rows)


def outlined(ids, outlines):
    rows = np.zeros(len(ids), TRACK)
    rows['track_id'] = ids
    return Tracks(rows, 5, 'cam', outlines=np.asarray(outlines, float))


SQUARES = [[(0, 0), (9, 0), (9, 9), (0, 9)], [(20, 0), (29, 0), (29, 9), (20, 9)]]


def test_outlines_have_the_layout_of_the_contract_and_the_header_of_the_tracks():
    cloud = cloud_of_outlines(outlined([3, 7], SQUARES))
    assert (cloud.height, cloud.width, cloud.point_step) == (1, 8, 12)
    layout = [(f.name, f.offset, f.datatype, f.count) for f in cloud.fields]
    assert layout == [('track_id', 0, 6, 1), ('u', 4, 7, 1), ('v', 8, 7, 1)]
    assert cloud.header == cloud_of_tracks(outlined([3, 7], SQUARES)).header
    assert cloud_of_outlines(Tracks(random_rows(TRACK, 3))).width == 0


@pytest.mark.parametrize('order', [[3, 7], [7, 3]])
def test_outlines_come_back_to_the_tracks_whose_they_are(order):
    cdr = serialize_message(cloud_of_outlines(outlined([3, 7], SQUARES)))
    stamp, points = outlines_of_serialized_cloud(cdr)
    bare = outlined([*order, 9], np.zeros((0, 0, 2)))
    back = tracks_with_outlines(bare, points).outlines
    assert stamp == 5
    np.testing.assert_array_equal(back[[order.index(3), order.index(7)]], SQUARES)
    assert np.isnan(back[2]).all()
    assert tracks_with_outlines(bare, points[:0]) is bare


@pytest.mark.parametrize('cut', [0, 1])
def test_outlines_of_different_lengths_stand_together(cut):
    """The one that is cut repeats its last point, whether others follow or not."""
    points = cloud_of_outlines(outlined([1, 2], SQUARES))
    _, points = outlines_of_serialized_cloud(serialize_message(points))
    points = np.delete(points, [4 * cut + 2, 4 * cut + 3])
    together = tracks_with_outlines(outlined([1, 2], np.zeros((0, 0, 2))), points).outlines
    np.testing.assert_array_equal(together[1 - cut], SQUARES[1 - cut])
    np.testing.assert_array_equal(together[cut], [*SQUARES[cut][:2], *SQUARES[cut][1:2] * 2])


def test_a_track_without_an_outline_has_no_points():
    cloud = cloud_of_outlines(outlined([1, 2], [np.full((4, 2), np.nan), SQUARES[1]]))
    _, points = outlines_of_serialized_cloud(serialize_message(cloud))
    assert points['track_id'].tolist() == [2] * 4


def test_what_is_no_message_of_outlines_is_refused():
    with pytest.raises(MessageError, match='not a serialized PointCloud2'):
        outlines_of_serialized_cloud(b'nothing of the kind')
    with pytest.raises(MessageError, match="without the field 'track_id'"):
        outlines_of_serialized_cloud(
            serialize_message(cloud_of_detections(Detections(random_rows(DETECTION, 2))))
        )
    cloud = cloud_of_outlines(outlined([3, 7], SQUARES))
    cloud.data[16:20] = array.array('B', np.float32('inf').tobytes())
    with pytest.raises(MessageError, match=r'outline of track 3: expected finite .* u inf'):
        outlines_of_serialized_cloud(serialize_message(cloud))
