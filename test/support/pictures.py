"""Random pictures with something to detect in them."""

from hypothesis import strategies as st
import numpy as np

from colortrack_ros.data import ENCODINGS
from colortrack_ros.data import Frame
from colortrack_ros.detection import ReferenceColor


@st.composite
def colors(draw, most=4):
    """Reference colors inside and outside of what a screen can show, spheres and ellipsoids."""
    count = draw(st.integers(1, most))
    number = st.floats(-80, 80)
    return tuple(
        ReferenceColor(
            f'color{k}',
            (draw(st.floats(0, 100)), draw(number), draw(number)),
            tolerance=draw(st.floats(1, 90)),
            tolerance_lab=draw(st.none() | st.tuples(*[st.floats(1, 90)] * 3)),
        )
        for k in range(count)
    )


@st.composite
def frames(draw, largest=40):
    """Patches of a few colors with a little noise, in any encoding, rows padded or not."""
    encoding = draw(st.sampled_from(list(ENCODINGS)))
    channels = ENCODINGS[encoding]
    height, width = draw(st.integers(1, largest)), draw(st.integers(1, largest))
    padding = draw(st.integers(0, 5))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    patch = draw(st.integers(1, 9))
    palette = random.integers(0, 256, (draw(st.integers(1, 5)), channels))
    small = random.integers(0, len(palette), (-(-height // patch), -(-width // patch)))
    whole = palette[np.kron(small, np.ones((patch, patch), int))[:height, :width]]
    noise = draw(st.sampled_from([0, 2, 10, 60]))
    whole = whole + random.integers(-noise, noise + 1, whole.shape)
    rows = np.zeros((height, width + padding, channels), np.uint8)
    rows[:, :width] = whole.clip(0, 255)
    image = rows[:, :width]
    if channels == 1 and draw(st.booleans()):
        image = image[..., 0]
    return Frame(image, encoding, stamp=draw(st.integers(0, 2**62)), frame_id='camera')
