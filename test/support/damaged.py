"""Videos with broken bytes, whose pictures carry their number."""

import cv2
import numpy as np


def numbered(k):
    """A picture that carries its number, with noise so that it takes room in a file."""
    image = np.random.default_rng(1).integers(60, 120, (96, 160, 3)).astype(np.uint8)
    image[16:48, 16 + k // 4 : 32 + k // 4] = (30, 60, 220)
    for bit in range(8):
        image[:16, 20 * bit : 20 * bit + 20] = 255 if k >> bit & 1 else 0
    return image


def number_of(frame):
    return sum(
        1 << bit for bit in range(8) if frame.image[4:12, 20 * bit + 5 :][:, :10].mean() > 128
    )


def damaged_video(path, codec, count=200, rate=25.0):
    """A video with a tenth of its bytes, in the middle, replaced by random ones."""
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), rate, (160, 96))
    for k in range(count):
        writer.write(numbered(k))
    writer.release()
    content = bytearray(path.read_bytes())
    first, last = int(0.45 * len(content)), int(0.55 * len(content))
    content[first:last] = np.random.default_rng(0).bytes(last - first)
    path.write_bytes(content)
    return str(path)
