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
