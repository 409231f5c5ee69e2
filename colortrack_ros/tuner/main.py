"""``tuner``: a web page to tune detector and tracker over a recording."""

import argparse
import asyncio
from collections.abc import Sequence
from pathlib import Path
import sys

from colortrack_ros.files import resolved
from colortrack_ros.signals import ending_signals

HELP = 'a topic of images, a bag, a video, pictures, a device, a stream, or scene:NAME'


def main(args: Sequence[str] | None = None) -> int:
    """Serve the page until a signal arrives.

    :return: the exit status: 0, or 1 if it could not start.
    """
    arguments = _parse(sys.argv[1:] if args is None else args)
    return asyncio.run(_serve(arguments))


def _parse(args: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog='tuner', description=__doc__)
    add = parser.add_argument
    add('source', nargs='?', default='scene:occlusion', help=f'{HELP}; default: scene:occlusion')
    add('--params-file', type=Path, metavar='YAML', help='to begin with, and to save to')
    add('--folder', type=Path, help='the only one that it writes to; default: that of the file')
    add('--topic', default='', help='of the images in a bag')
    add('--rate', type=float, default=0.0, help='frames a second, of pictures')
    add('--address', default='127.0.0.1', help='to listen on; another one asks for a token')
    add('--port', type=int, default=8600, help='0 for any; default: 8600')
    end = list(args).index('--ros-args') if '--ros-args' in args else len(args)
    arguments = parser.parse_args(args[:end])
    arguments.ros = list(args[end + 1 :])
    return arguments


def _folder_of(arguments: argparse.Namespace) -> Path:
    """Return the folder that files are read from and saved to.

    :raises ValueError: it is not there.
    """
    file: Path | None = arguments.params_file
    folder: Path = arguments.folder or (file.parent if file else Path())
    if not folder.is_dir():
        raise ValueError(f'--folder {folder}: expected a folder that is there')
    return folder


async def _serve(arguments: argparse.Namespace) -> int:
    # Not at the top, so that a missing aiohttp is reported in one line.
    from aiohttp import web

    from colortrack_ros.sources import SourceError
    from colortrack_ros.tuner.folder import Folder
    from colortrack_ros.tuner.gate import Gate
    from colortrack_ros.tuner.opening import open_footage
    from colortrack_ros.tuner.running import RunningNodes
    from colortrack_ros.tuner.server import Server
    from colortrack_ros.tuner.session import Session

    stop = asyncio.Event()
    for number in ending_signals():
        asyncio.get_running_loop().add_signal_handler(number, stop.set)
    file: Path | None = arguments.params_file
    try:
        folder = _folder_of(arguments)
        running = RunningNodes(arguments.ros)
        footage = open_footage(
            arguments.source, running, rate=arguments.rate, topic=arguments.topic
        )
        name = str(resolved(file).relative_to(resolved(folder))) if file else ''
        session = Session(footage, Folder(folder), running, name)
        gate = Gate(arguments.address)
        runner = web.AppRunner(Server(session, gate).app, access_log=None)
        await runner.setup()
        await web.TCPSite(runner, arguments.address, arguments.port, shutdown_timeout=1.0).start()
    except (SourceError, ValueError, OSError) as error:
        print(f'tuner: {error}', file=sys.stderr)
        return 1
    gate.port = runner.addresses[0][1]
    print(f'tuner: {gate.url} (Ctrl-C ends it)', flush=True)
    await stop.wait()
    await runner.cleanup()
    footage.close()
    running.close()
    return 0
