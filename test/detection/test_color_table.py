from dataclasses import replace

from hypothesis import assume
from hypothesis import given
from hypothesis import settings
import numpy as np
import pytest
from support import pictures
from support import textbook

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.detection import color_table
from colortrack_ros.detection import column_filter
from colortrack_ros.detection import ReferenceColor
from colortrack_ros.detection.color_table import ColorTable
from colortrack_ros.detection.column_filter import ColumnFilter

LUTS = sorted({False, color_table.HAS_16_BIT_LUT})


@pytest.mark.slow
@pytest.mark.parametrize('has_lut', LUTS)
@settings(deadline=None, max_examples=60)
@given(frame=pictures.frames(), colors=pictures.colors())
def test_the_mask_is_that_of_the_float_computation(has_lut, frame, colors):
    assume(textbook.is_decided(frame, colors))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(color_table, 'HAS_16_BIT_LUT', has_lut)
        table = ColorTable(colors)
    labels = table.label(frame.image, frame.encoding).pixels
    np.testing.assert_array_equal(labels, textbook.labels(frame, colors))
    np.testing.assert_array_equal(
        table.label(frame.image, frame.encoding).pixels, labels, 'the second time, from memory'
    )


def test_all_colors_around_a_boundary_are_exact():
    red, green = np.meshgrid(np.arange(256), np.arange(256))
    image = np.stack([red, green, np.full_like(red, 90)], axis=-1).astype(np.uint8)
    frame = Frame(image, 'rgb8')
    colors = (
        ReferenceColor.from_rgb('a', (200, 60, 90), 40.0),
        ReferenceColor.from_rgb('b', (150, 90, 90), 30.0),
    )
    labels = ColorTable(colors).label(image, 'rgb8').pixels
    np.testing.assert_array_equal(labels, textbook.labels(frame, colors))
    assert set(np.unique(labels)) == {0, 1, 2}


def test_at_equal_distance_the_first_color_wins():
    lab = (50.0, 20.0, 20.0)
    colors = (ReferenceColor('a', lab, 200.0), ReferenceColor('b', lab, 200.0))
    image = np.full((2, 3, 3), 128, np.uint8)
    assert (ColorTable(colors).label(image, 'bgr8').pixels == 1).all()


@pytest.mark.slow
def test_the_largest_number_of_colors():
    random = np.random.default_rng(0)
    colors = tuple(
        ReferenceColor.from_rgb(f'{k}', random.integers(0, 256, 3).tolist(), 5.0)
        for k in range(254)
    )
    image = random.integers(0, 256, (40, 50, 3), dtype=np.uint8)
    labels = ColorTable(colors).label(image, 'rgb8').pixels
    np.testing.assert_array_equal(labels, textbook.labels(Frame(image, 'rgb8'), colors))
    assert labels.max() == 254


@pytest.mark.parametrize('encoding', [name for name in ENCODINGS if name != 'mono8'])
@pytest.mark.parametrize('share', [0.0, 1.0])
def test_columns_that_are_ruled_out_hold_no_color(encoding, share, monkeypatch):
    monkeypatch.setattr(color_table, 'HAS_16_BIT_LUT', False)
    monkeypatch.setattr(column_filter, 'JOIN_PIXELS', 50)
    random = np.random.default_rng(1)
    image = random.normal(120, 6, (40, 600, ENCODINGS[encoding])).clip(0, 255).astype(np.uint8)
    for k, color in enumerate(((200, 40, 30), (250, 250, 250), (10, 10, 10), (30, 60, 220))):
        image[5:9, 20 + 150 * k : 26 + 150 * k, :3] = color
    frame = Frame(image, encoding)
    colors = tuple(
        ReferenceColor.from_rgb(f'{k}', rgb, 30.0)
        for k, rgb in enumerate(((200, 40, 30), (250, 250, 250), (10, 10, 10), (30, 60, 220)))
    )
    for some in (*((color,) for color in colors), colors):
        table = ColorTable(some)
        table._column_filter._share = share
        for _ in range(2):
            labels = table.label(image, encoding).pixels
            np.testing.assert_array_equal(labels, textbook.labels(frame, some))
        parts = ColumnFilter.parts(table._column_filter, image, encoding)
        looked_at = sum(right - left for left, right in parts)
        assert looked_at == 600 if share else 0 < looked_at <= 150 * len(some)


@pytest.mark.parametrize('has_lut', LUTS)
@pytest.mark.parametrize('height', [1, 2, 3, 301])
def test_threads_and_strips_do_not_change_the_result(height, has_lut, monkeypatch):
    monkeypatch.setattr(color_table, 'HAS_16_BIT_LUT', has_lut)
    monkeypatch.setattr(color_table, 'STRIP', 20_000)
    monkeypatch.setattr(color_table, 'LONG_STRIP', 30_000)
    random = np.random.default_rng(5)
    image = random.integers(90, 160, (height, 1000, 3), dtype=np.uint8)
    colors = (ReferenceColor('gray', (50.0, 0.0, 0.0), 12.0),)
    expected = textbook.labels(Frame(image), colors)
    for threads in (1, 2, 3):
        labels = ColorTable(colors, threads).label(image, 'bgr8').pixels
        np.testing.assert_array_equal(labels, expected)


BALLS = ((205, 58, 34), (40, 160, 60), (40, 70, 200), (220, 200, 40))


def spread(seed, reach=12.0):
    """Colors that differ in each draw, by as much as light and noise make them."""
    shift = np.random.default_rng(seed).normal(0, 3, (len(BALLS), 3))
    colors = (ReferenceColor.from_rgb(f'{k}', rgb, reach) for k, rgb in enumerate(BALLS))
    return tuple(
        replace(color, lab=tuple(np.add(color.lab, by).tolist()), inverted=color.name == '3')
        for color, by in zip(colors, shift, strict=True)
    )


def of_all_hues(seed):
    """Pixels around all colors of the balls, as noise spreads them, rgb8."""
    random = np.random.default_rng(seed)
    around = np.array(BALLS)[random.integers(0, len(BALLS), (60, 70))]
    return (around + random.normal(0, 15, around.shape)).clip(0, 255).astype(np.uint8)


@pytest.mark.slow
@pytest.mark.parametrize('few', [0, 1 << 16])
def test_a_table_that_takes_other_colors_labels_as_a_new_one(few):
    image, colors = of_all_hues(0), spread(0)
    table = ColorTable(colors, most_whole=few)
    for k in range(12):
        changed = spread(k, reach=6.0 + 4 * (k % 4))
        colors = tuple(changed[j] if j % (1 + k % 3) == 0 else colors[j] for j in range(4))
        table.take(colors)
        new = ColorTable(colors)
        labels = table.label(image, 'rgb8').pixels
        np.testing.assert_array_equal(labels, new.label(image, 'rgb8').pixels)
        assert (table.overlaps, table.holds_gray) == (new.overlaps, new.holds_gray)
        np.testing.assert_array_equal(table.touched, new.touched)


def test_when_one_color_changes_only_what_it_touches_is_labeled_anew(monkeypatch):
    """All colors of all cells at a surface were: 200 ms with eight colors, four times a second."""
    image, labeled = of_all_hues(0), []
    whole = color_table.lab_from_rgb
    monkeypatch.setattr(
        color_table, 'lab_from_rgb', lambda rgb: (labeled.append(len(rgb)), whole(rgb))[1]
    )
    colors = tuple(replace(color, inverted=False) for color in spread(0))
    table = ColorTable(colors, most_whole=color_table.FEW_CELLS)
    table.label(image, 'rgb8')
    first = sum(labeled)
    labeled.clear()
    table.take((replace(colors[0], lab=tuple(np.add(colors[0].lab, 2.0).tolist())), *colors[1:]))
    table.label(image, 'rgb8')
    assert first - 256 <= image.size // 3, 'no color that is not in the picture'
    assert 0 < sum(labeled) - 256 < first / 3
