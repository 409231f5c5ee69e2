"""What a robot follows around corners, and how late it learns of it."""

SECOND = 1_000_000_000
TICK = 20_000_000
LATENCY = 60_000_000
"""What a picture takes through detector, tracker and locator."""


def around_corners(t, speed=0.4):
    """A square of 2 m."""
    way = speed * t % 8
    side, rest = divmod(way, 2)
    x, y = [(rest, 0), (2, rest), (2 - rest, 2), (0, 2 - rest)][int(side)]
    return 1.0 + x, y
