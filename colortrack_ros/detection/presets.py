"""Common names of colors."""

from colortrack_ros.detection.lab import Triple

PRESETS: dict[str, tuple[Triple, Triple]] = {
    'red': ((43.0, 60.0, 40.0), (30.0, 28.0, 28.0)),
    'orange': ((65.0, 40.0, 62.0), (25.0, 18.0, 32.0)),
    'yellow': ((82.0, 0.0, 70.0), (25.0, 18.0, 38.0)),
    'green': ((55.0, -46.0, 36.0), (38.0, 30.0, 30.0)),
    'cyan': ((70.0, -32.0, -18.0), (28.0, 20.0, 18.0)),
    'blue': ((36.0, 16.0, -54.0), (28.0, 28.0, 32.0)),
    'purple': ((38.0, 48.0, -48.0), (22.0, 22.0, 22.0)),
    'magenta': ((48.0, 66.0, -28.0), (30.0, 32.0, 28.0)),
    'pink': ((70.0, 45.0, 0.0), (20.0, 26.0, 22.0)),
    'white': ((96.0, 0.0, 0.0), (14.0, 10.0, 10.0)),
    'black': ((6.0, 0.0, 0.0), (18.0, 12.0, 12.0)),
}
"""By name, the color that it is typical of, and half axes of the ellipsoid of those that it may
stand for, of painted objects in daylight. Chosen to include the shades that
test/detection/test_config.py lists for each name, and to exclude gray and skin."""

Range = tuple[float, float]

HUES: dict[str, tuple[Range, Range]] = {
    'red': ((0.0, 45.0), (8.0, 65.0)),
    'orange': ((45.0, 78.0), (40.0, 90.0)),
    'yellow': ((78.0, 112.0), (50.0, 100.0)),
    'green': ((110.0, 190.0), (8.0, 95.0)),
    'cyan': ((180.0, 235.0), (25.0, 95.0)),
    'blue': ((230.0, 310.0), (8.0, 90.0)),
    'purple': ((308.0, 330.0), (8.0, 80.0)),
    'magenta': ((325.0, 360.0), (25.0, 90.0)),
    'pink': ((330.0, 400.0), (50.0, 95.0)),
}
"""By name, the range of hues [degrees in CIELAB] and that of lightness of all that it may stand for
where nothing typical of it is in the picture. Chosen to include the colors of CSS with this name
(test/detection/test_named.py)."""
