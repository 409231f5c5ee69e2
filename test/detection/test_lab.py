import numpy as np
import pytest
from support import textbook

from colortrack_ros.detection.cells import cell_bounds
from colortrack_ros.detection.cells import lab_of_cells
from colortrack_ros.detection.lab import lab_from_rgb


@pytest.mark.parametrize(
    ('rgb', 'lab'),
    [
        ((255, 255, 255), (100, 0, 0)),
        ((0, 0, 0), (0, 0, 0)),
        ((119, 119, 119), (50.03, 0, 0)),
        ((255, 0, 0), (53.24, 80.09, 67.20)),
        ((0, 255, 0), (87.73, -86.18, 83.18)),
        ((0, 0, 255), (32.30, 79.19, -107.86)),
    ],
)
def test_the_primaries_have_the_values_of_the_tables(rgb, lab):
    np.testing.assert_allclose(lab_from_rgb(np.array(rgb, np.uint8)), lab, atol=0.02)


def test_it_is_the_textbook_formula():
    rgb = np.random.default_rng(0).integers(0, 256, (20_000, 3), dtype=np.uint8)
    np.testing.assert_allclose(lab_from_rgb(rgb), textbook.lab(rgb), atol=1e-9)


def test_a_color_alone_has_the_same_bits_as_among_others():
    rgb = np.random.default_rng(1).integers(0, 256, (1000, 3), dtype=np.uint8)
    together = lab_from_rgb(rgb)
    assert all(np.array_equal(lab_from_rgb(rgb[k]), together[k]) for k in range(len(rgb)))


def test_every_color_of_a_cell_is_within_its_bounds():
    random = np.random.default_rng(2)
    cell = np.arange(1 << 16)
    low = np.stack([cell >> 11 << 3, (cell >> 5 & 63) << 2, (cell & 31) << 3], axis=-1)
    center, radius = cell_bounds()
    for _ in range(10):
        rgb = (low + random.integers(0, [8, 4, 8], low.shape)).astype(np.uint8)
        assert (np.abs(lab_from_rgb(rgb).T - center) <= radius).all()


def test_colors_of_cells_come_in_columns():
    """NumPy takes a fifth of the time for what is done with them, as in a look at the colors."""
    cells = np.arange(7, 65536, 97)
    lab = lab_of_cells(cells)
    np.testing.assert_array_equal(lab, cell_bounds()[0].T[cells])
    assert lab.flags.f_contiguous
