"""``pick_color``: reads a reference color from a picture, ready to paste into a params file."""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
import sys
import time

import numpy as np
from numpy.typing import NDArray
import rclpy
from rclpy.qos import qos_profile_sensor_data
from rclpy.utilities import remove_ros_args
from sensor_msgs.msg import Image

from colortrack_ros.data import Frame
from colortrack_ros.detection import Detector
from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.extent import LARGEST_SHARE
from colortrack_ros.detection.pick import pick_color
from colortrack_ros.detection.pick import PickedColor
from colortrack_ros.detection.pick import side_by_side
from colortrack_ros.detection.teach import Example
from colortrack_ros.detection.teach import teach_color
from colortrack_ros.drawing import write_picture
from colortrack_ros.messages import frame_of_serialized_image
from colortrack_ros.messages import MessageError
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.node_kit.runtime import use_transport_profile
from colortrack_ros.parameters.config import specs_of
from colortrack_ros.sources import open_source
from colortrack_ros.sources import SourceError
from colortrack_ros.tools.color_params import write_color
from colortrack_ros.tools.color_params import yaml_of

IMAGE_TIMEOUT = 5.0
"""How long [s] to wait for an image on a topic: discovery takes a second or two, and the slowest
cameras publish one image per second."""

SAME_COLORS = (
    'What is not it has the very colors of what is, so no color tells them apart, and their sizes '
    'and shapes are alike, too: moving_only may.'
)

LOOK_ELSEWHERE = (
    'Look at other pictures, too: what is found there and is not it is --also-not SOURCE FRAME U V.'
)
SHOW_ELSEWHERE = (
    'These shades are those of one picture: show it in another, --also SOURCE FRAME U V, where '
    'there is other light on it.'
)

PLACE_ELSEWHERE = ('SOURCE', 'FRAME', 'U', 'V')
REPEATED = (
    ('--box', 'box', int, tuple('UVWH'), 'a region'),
    ('--not', 'other', float, tuple('UV'), 'a pixel that is not it'),
    ('--also', 'also', str, PLACE_ELSEWHERE, 'a pixel of another picture that is it'),
    ('--also-not', 'also_other', str, PLACE_ELSEWHERE, 'a pixel of another picture that is not it'),
)
"""Options that may be given several times: name, where it is kept, kind, what it takes, help."""


def main(args: Sequence[str] | None = None) -> int:
    """Pick a color.

    :return: the exit status: 0, or 1 if it failed.
    """
    arguments = _parse(args)
    try:
        frame = _frame_of(arguments.source, arguments.frame)
        picked = _pick(frame, arguments)
        config = replace(DetectorConfig(colors=(picked.color,)), **picked.limits)
        _save(arguments.output, side_by_side(frame, Detector(config)))
        if arguments.write:
            write_color(arguments.write, picked.color, picked.limits)
    except (StartError, SourceError, ValueError) as error:
        print(f'pick_color: {error}', file=sys.stderr)
        return 1
    print(f'# expected area: {picked.area} px\n{yaml_of(picked.color, picked.limits)}')
    print(_advice(picked), file=sys.stderr)
    if picked.telling:
        print(
            f'What is not it has its colors, and is told by {", ".join(picked.telling)}.',
            file=sys.stderr,
        )
    elif (arguments.other or arguments.also_other) and not picked.color.others:
        print(SAME_COLORS, file=sys.stderr)
    print(f'Look at {arguments.output}: the picture, the mask and the blobs.', file=sys.stderr)
    if not arguments.also and not picked.color.is_sought:
        print(SHOW_ELSEWHERE, file=sys.stderr)
    elif not arguments.also_other:
        print(LOOK_ELSEWHERE, file=sys.stderr)
    return 0


def _pick(frame: Frame, arguments: argparse.Namespace) -> PickedColor:
    """The color of what is given: by itself, or with others as examples.

    :raises SourceError, ValueError: a picture cannot be read, or a place is not inside of it.
    """
    pixels = np.rint(np.reshape(arguments.pixels, (-1, 2))).astype(int).tolist()
    boxes = [tuple(box) for box in arguments.box] + [(u, v, 1, 1) for u, v in pixels]
    more = arguments.other or arguments.also or arguments.also_other
    if len(boxes) == 1 and pixels and not more:
        ((u, v),) = pixels
        return pick_color(frame, u, v, arguments.name)
    examples = [Example(frame, box) for box in boxes]
    for source, number, u, v in arguments.also:
        examples.append(Example(_frame_of(source, number), (round(u), round(v), 1, 1)))
    others = [Example(frame, (round(u), round(v), 1, 1)) for u, v in arguments.other]
    for source, number, u, v in arguments.also_other:
        others.append(Example(_frame_of(source, number), (round(u), round(v), 1, 1)))
    return teach_color(examples, others, arguments.name)


def _parse(args: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='pick_color', description=__doc__)
    parser.add_argument('source', help='a picture, a video, scene:NAME, or the topic of an Image')
    parser.add_argument('pixels', nargs='*', type=float, metavar='U V', help='pixels that are it')
    for option, name, kind, what, said in REPEATED:
        parser.add_argument(
            option,
            dest=name,
            nargs=len(what),
            type=kind,
            action='append',
            default=[],
            metavar=what,
            help=said,
        )
    parser.add_argument('--frame', type=int, default=0, help='of a video, from 0')
    parser.add_argument('--name', default='picked', help='of the color')
    parser.add_argument(
        '--write', type=Path, metavar='YAML', help='a params file to change, or to make'
    )
    parser.add_argument('--output', type=Path, default=Path('pick_color.png'), help='the picture')
    given = sys.argv if args is None else ['pick_color', *args]
    try:
        words = remove_ros_args(given)[1:]
    except Exception as error:  # rclpy's errors have no common base class
        parser.error(f'bad ROS arguments: {" ".join(str(error).split())}')
    return _checked(parser, parser.parse_intermixed_args(words))


def _checked(parser: argparse.ArgumentParser, arguments: argparse.Namespace) -> argparse.Namespace:
    """The arguments, with numbers where they are due; ends the program where they are not."""
    if arguments.name in {spec.name for spec in specs_of(DetectorConfig)}:
        parser.error(f'--name {arguments.name}: is a parameter of the detector; give another name')
    if len(arguments.pixels) % 2 or not (arguments.pixels or arguments.box):
        parser.error('expected pixels, u and v of each, or a region, --box u v w h')
    try:
        for name in ('also', 'also_other'):
            given = getattr(arguments, name)
            setattr(arguments, name, [(s, int(n), float(u), float(v)) for s, n, u, v in given])
    except ValueError:
        parser.error('expected SOURCE FRAME U V, three numbers after the source')
    places = [*arguments.also, *arguments.also_other]
    if min([arguments.frame, *(number for _, number, _, _ in places)]) < 0:
        parser.error('expected frames from 0')
    if not np.isfinite([*arguments.pixels, *np.ravel(arguments.other)]).all():
        parser.error('expected finite numbers')
    return arguments


def _save(path: Path, picture: NDArray[np.uint8]) -> None:
    """Write a picture.

    :raises ValueError: it cannot be written.
    """
    try:
        write_picture(path, picture)
    except OSError as error:
        raise ValueError(f'{path}: {error.strerror}') from error


def _advice(picked: PickedColor) -> str:
    """How much of the picture the color covers, and what to do if that is too much."""
    said = f'{picked.color.name} covers {picked.share:.1%} of the picture'
    if picked.share > LARGEST_SHARE:
        return (
            f'{said}: pick another side of the thing, or set moving_only if the thing alone moves.'
        )
    if picked.runs_on:
        return (
            f'{said}, and runs into other colors: pick another side, or pixels that are --not it.'
        )
    return f'{said}.'


def _frame_of(source: str, number: int) -> Frame:
    """A frame of a recording, or the next one on a topic."""
    if source.startswith('/') and not Path(source).exists():
        return _frame_on(source)
    frames = open_source(source)
    try:
        for _ in range(number):
            frames.read()
        frame = frames.read()
    finally:
        frames.close()
    if frame is None:
        raise ValueError(f'--frame {number}: {source} has fewer frames')
    return frame


def _frame_on(topic: str) -> Frame:
    use_transport_profile()
    rclpy.init()
    node = rclpy.create_node('pick_color')
    heard: list[bytes] = []
    node.create_subscription(Image, topic, heard.append, qos_profile_sensor_data, raw=True)
    end = time.monotonic() + IMAGE_TIMEOUT
    while not heard and time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)
    node.destroy_node()
    rclpy.shutdown()
    if not heard:
        raise StartError(
            f'{topic}: no file, and no sensor_msgs/Image on it for {IMAGE_TIMEOUT:g} s'
        )
    try:
        return frame_of_serialized_image(heard[0])
    except MessageError as error:
        raise StartError(f'{topic}: {error}') from error
