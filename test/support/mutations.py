"""Messages that lie, and others that are broken on their way."""

import random

from rclpy.serialization import serialize_message
from sensor_msgs.msg import CompressedImage
from sensor_msgs.msg import Image
from sensor_msgs.msg import PointCloud2

STAMPS = [-(2**31), -62135596800 % 2**31, 4102444800 - 2**31, -1, 2**31 - 1]
WRONG_IMAGE = {
    'width': [0, 1, 2**31],
    'height': [0, 1, 2**31],
    'step': [0, 1, 2**31],
    'encoding': ['', '32FC1', 'bgr8x'],
    'data': [b'', b'12'],
    'stamp': STAMPS,
}
WRONG_CLOUD = {
    'width': [0, 1, 2**31],
    'height': [0, 2, 2**31],
    'point_step': [0, 1, 73],
    'row_step': [0, 1],
    'fields': [[]],
    'data': [b'', b'12', b'\xff' * (72 * 5)],
    'is_bigendian': [True],
    'stamp': STAMPS,
}
WRONG = {
    Image: WRONG_IMAGE,
    CompressedImage: {'data': [b'', b'1234'], 'format': ['', 'x' * 99], 'stamp': STAMPS},
    PointCloud2: WRONG_CLOUD,
}


def lies(good) -> list:
    """Copies of a message, each with one field changed."""
    copies = []
    for name, values in WRONG[type(good)].items():
        for value in values:
            copy = type(good)(**{f: getattr(good, f) for f in good.get_fields_and_field_types()})
            if name == 'stamp':
                copy.header = type(good.header)(frame_id='x')
                copy.header.stamp.sec = value
            else:
                setattr(copy, name, value)
            copies.append(copy)
    return copies


def mutations(good, count: int, seed: int) -> list[bytes]:
    """Serialized messages that lie, and others with bytes changed, cut out and put in."""
    chance = random.Random(seed)
    wrong = [bytes(serialize_message(message)) for message in lies(good)]
    originals = [bytes(serialize_message(good)), *wrong]
    for _ in range(count - len(wrong)):
        cdr = bytearray(chance.choice(originals))
        for _ in range(chance.randint(1, 6)):
            # most of what can be wrong stands at the beginning
            at = chance.randrange(4, min(len(cdr), chance.choice([60, 120, 900])))
            kind = chance.random()
            if kind < 0.7:
                cdr[at] = chance.choice([0, 1, 127, 255, chance.randrange(256)])
            elif kind < 0.85:
                del cdr[at : at + chance.randint(1, 40)]
            else:
                cdr[at:at] = chance.randbytes(chance.randint(1, 40))
            if len(cdr) < 20:
                break
        wrong.append(bytes(cdr))
    return wrong
