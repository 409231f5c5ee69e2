"""Whatever comes in raises no exception, and all that comes out is finite."""

import warnings

from hypothesis import given
from hypothesis import settings
from hypothesis import strategies as st
import numpy as np
import pytest

from colortrack_ros.data import DETECTION
from colortrack_ros.data import Detections
from colortrack_ros.estimation.motion import MOTION_MODELS
from colortrack_ros.tracking import Tracker
from colortrack_ros.tracking import TrackerConfig

VALUES = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True),
    st.floats(-2000, 2000),
    st.sampled_from([0.0, 1.0, 1e-300, 1e6, 1e12, 1e300, 100.0, 101.0]),
)
ROWS = st.lists(st.lists(VALUES, min_size=11, max_size=11), max_size=6)
STAMPS = st.lists(st.one_of(st.integers(0, 10**9), st.integers(-(2**61), 2**61)), min_size=12)


@pytest.mark.slow
@pytest.mark.filterwarnings('ignore:refused')
@settings(max_examples=60, deadline=None)
@given(st.lists(ROWS, min_size=12, max_size=12), STAMPS, st.sampled_from(sorted(MOTION_MODELS)))
def test_any_numbers_give_finite_tracks(frames, stamps, model):
    tracker = Tracker(TrackerConfig(motion_model=model))
    for given_rows, stamp in zip(frames, stamps, strict=False):
        rows = np.zeros(len(given_rows), DETECTION)
        with warnings.catch_warnings(), np.errstate(all='ignore'):
            warnings.simplefilter('ignore')
            for name, column in zip(DETECTION.names, np.array(given_rows).T, strict=False):
                rows[name] = column
        tracks = tracker.update(Detections(rows, stamp))
        for name in ('u', 'v', 'du', 'dv', 'covariance', 'score'):
            assert np.isfinite(tracks.rows[name]).all(), name


@pytest.mark.parametrize('name', ['u', 'v', 'cov_uu', 'cov_vv', 'area', 'box_w'])
@pytest.mark.parametrize('value', [np.nan, np.inf, -np.inf, 1e30])
def test_an_absurd_row_is_dropped_and_counted(name, value):
    rows = np.zeros(2, DETECTION)
    rows['cov_uu'] = rows['cov_vv'] = 1.0
    rows['area'] = 9.0
    rows[name][1] = value
    tracker = Tracker()
    with pytest.warns(UserWarning, match='refused: detections: expected'):
        assert len(tracker.update(Detections(rows)).rows) == 1
    assert tracker.screening.dropped == 1


@pytest.mark.slow
@pytest.mark.parametrize('model', sorted(MOTION_MODELS))
def test_tracks_torn_between_detections_a_million_pixels_apart_are_stitched_without_an_error(model):
    config = TrackerConfig(
        associator='jpda', gating=False, motion_model=model, measurement_noise=1e-3,
        initial_speed=1e-3, max_position_sigma=1e9, max_time_since_update=3600.0,
        confirm_hits=1, confirm_window=1,
    )  # fmt: skip
    for seed in range(3):
        random, tracker, stamp = np.random.default_rng(seed), Tracker(config), 0
        for _ in range(40):
            rows = np.zeros(random.integers(6), DETECTION)
            for name in ('u', 'v'):
                rows[name] = random.choice([0.0, 100.0, 1e6, -1e6], len(rows))
            rows['color'] = random.integers(0, 2, len(rows))
            stamp += int(random.choice([1, 33_333_333, 10**9]))
            with np.errstate(all='raise', under='ignore'):
                tracks = tracker.update(Detections(rows, stamp))
            assert np.isfinite(tracks.rows['covariance']).all()


def test_rows_that_were_joined_without_their_padding_are_taken():
    """np.concatenate drops the padding of DETECTION."""
    rows = np.concatenate([np.zeros(1, DETECTION), np.zeros(1, DETECTION)])
    rows['u'] = 10.0, 200.0
    assert rows.dtype.itemsize < DETECTION.itemsize
    assert len(Tracker().update(Detections(rows, 0, 'camera')).rows) == 2
