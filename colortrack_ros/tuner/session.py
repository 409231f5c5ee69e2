"""The state that all users of the page share: workbench, settings, samples and file."""

import base64
from collections.abc import Mapping
from dataclasses import asdict
from dataclasses import replace
import shlex
from typing import Any

from colortrack_ros.detection.teach import Example
from colortrack_ros.parameters.params_file import flow
from colortrack_ros.parameters.params_file import given_in
from colortrack_ros.tools.color_params import color_values
from colortrack_ros.tuner.folder import difference
from colortrack_ros.tuner.folder import digest
from colortrack_ros.tuner.folder import Folder
from colortrack_ros.tuner.footage import Footage
from colortrack_ros.tuner.labeling import Labeling
from colortrack_ros.tuner.labels import Mark
from colortrack_ros.tuner.measures import plane_of
from colortrack_ros.tuner.running import RunningNodes
from colortrack_ros.tuner.samples import Sample
from colortrack_ros.tuner.samples import taught
from colortrack_ros.tuner.settings import colors_of
from colortrack_ros.tuner.settings import CONFIGS
from colortrack_ros.tuner.settings import Settings
from colortrack_ros.tuner.snapshot import snapshot
from colortrack_ros.tuner.view import jpeg_of
from colortrack_ros.tuner.view import png_of
from colortrack_ros.tuner.workbench import Workbench

Reply = dict[str, Any]


class Session:
    """Carries out the commands of the page. Only one thread at a time may use it.

    :param footage: the recording.
    :param folder: of the params files.
    :param running: whose nodes may be tuned.
    :param file: the initial one, empty for none.
    :raises ValueError: the file cannot be read.
    """

    def __init__(
        self, footage: Footage, folder: Folder, running: RunningNodes, file: str = ''
    ) -> None:
        self._folder, self._running, self._file = folder, running, file
        self._attached: dict[str, str] = {}
        self._text = folder.read_or_empty(file) if file else ''
        self._samples: tuple[Sample, ...] = ()
        self._samples_before: list[tuple[Sample, ...]] = []
        self.bench = Workbench(footage, Settings(self._text))
        self._labeling = Labeling(footage)

    @property
    def settings(self) -> Settings:
        """The parameters in force."""
        return self.bench.settings

    def do(self, command: str, fields: dict[str, Any]) -> Reply | None:
        """Carry out a validated command.

        :returns: the answer for the sender alone.
        :raises ValueError: it is refused, with the reason.
        """
        reply: Reply | None = getattr(self, f'_{command}')(**fields)
        return reply

    def state(self) -> Reply:
        """The state that everybody sees, except the picture."""
        bench, settings = self.bench, self.settings
        return {
            'is': 'state',
            'source': bench.footage.label,
            'total': bench.footage.total,
            'rate': bench.footage.rate,
            'playing': bench.playing,
            'values': {node: settings.in_force(node) for node in CONFIGS},
            'given': {node: list(settings.given(node)) for node in CONFIGS},
            'colors': colors_of(settings.detector),
            'regions': [asdict(region) for region in settings.detector.regions],
            'samples': [
                {'color': s.color, 'is_it': s.is_it, 'shades': s.example.shades().round(1).tolist()}
                for s in self._samples
            ],
            'refused': settings.refused,
            'attached': self._attached,
            'labeling': self._labeling.state(),
            'live': bench.footage.live,
            'waiting': bench.view is None,
            'trouble': bench.footage.trouble,
            'changes': settings.changes,
            'file': self._file,
            'folder': str(self._folder.root),
            'files': self._folder.names(),
            'unsaved': self._is_unsaved(),
        }

    def _is_unsaved(self) -> bool:
        """Whether the settings differ from the file, also if they cannot be written into it."""
        try:
            return self.settings.written_into(self._text) != self._text
        except ValueError:
            return True

    def _play(self) -> None:
        self.bench.play()

    def _pause(self) -> None:
        self.bench.pause()

    def _seek(self, frame: int) -> None:
        self.bench.seek(frame)

    def _step(self, by: int) -> None:
        view = self.bench.view
        self.bench.pause()
        if by == 1:
            self.bench.step()
        elif view:
            self.bench.seek(view.number + by)

    def _set(self, node: str, values: dict[str, Any], follows: bool) -> Reply:
        return self._change(node, values, self._samples, follows=follows)

    def _undo(self) -> None:
        for node in self._attached:
            self._give(node, self.settings.before(node))
        self.settings.undo()
        self._samples = self._samples_before.pop()
        self.bench.configure()

    def _sample(self, color: str, is_it: bool, u: int, v: int, width: int, height: int) -> Reply:
        view = self.bench.view
        if view is None:
            raise ValueError('sample: there is no picture')
        example = Example(view.frame, (u, v, width, height))
        samples = (*self._samples, Sample(color, example, is_it))
        picked = taught(samples, color, self.settings.detector)
        values = color_values(self.settings.given('detector'), picked.color, picked.limits)
        return self._change('detector', values, samples)

    def _remove_color(self, color: str) -> None:
        given = self.settings.given('detector')
        names = [c.name for c in self.settings.detector.colors if c.name != color]
        gone = {name: None for name in given if name.startswith(f'{color}.')}
        samples = tuple(sample for sample in self._samples if sample.color != color)
        self._change('detector', {'colors': names, **gone}, samples)

    def _rename_color(self, color: str, to: str) -> None:
        names = [c.name for c in self.settings.detector.colors]
        if color not in names or to in names:
            raise ValueError(f'name: expected a color of {names} and a new name, got {color}, {to}')
        given = self.settings.given('detector')
        mine = {name: value for name, value in given.items() if name.startswith(f'{color}.')}
        values: dict[str, Any] = {'colors': [to if name == color else name for name in names]}
        values |= dict.fromkeys(mine)
        values |= {f'{to}.{name.partition(".")[2]}': value for name, value in mine.items()}
        samples = (replace(s, color=to) if s.color == color else s for s in self._samples)
        self._change('detector', values, tuple(samples))

    def _background(self) -> Reply:
        """The static background, and the mask of what moves; both empty while unknown."""
        found = self.bench.background()
        files = (jpeg_of(found[0]), png_of(found[1])) if found else (b'', b'')
        picture, moves = (base64.b64encode(file).decode() for file in files)
        return {'is': 'background', 'picture': picture, 'moves': moves}

    def snapshot(self) -> bytes:
        """The current frame and everything that belongs to it, see :func:`snapshot`.

        :raises ValueError: there is none.
        """
        view = self.bench.view
        if view is None:
            raise ValueError('snapshot: there is no picture')
        return snapshot(view, self.bench.footage.label, self.settings.written_into(''))

    def _learn_background(self) -> None:
        self.bench.learn_background()

    def _load(self, path: str) -> None:
        text = self._folder.read(path)
        settings = Settings(text)
        for node in self._attached:
            self._give(node, settings.given(node))
        settings.revision = self.settings.revision + 1
        self.bench.settings = settings
        self._file, self._text = path, text
        self._samples, self._samples_before = (), []
        self.bench.configure()

    def _diff(self, path: str) -> Reply:
        old = self._folder.read_or_empty(path)
        new = self.settings.written_into(old)
        diff = difference(path, old, new)
        return {'is': 'diff', 'path': path, 'diff': diff, 'digest': digest(old, new)}

    def _save(self, path: str, digest: str) -> Reply:
        seen = self._diff(path)
        if seen['digest'] != digest:
            raise ValueError(f'{path}: has changed since the difference was shown; look again')
        text = self.settings.written_into(self._folder.read_or_empty(path))
        self._folder.write(path, text)
        self._file, self._text = path, text
        return {'is': 'saved', 'path': str(self._folder.root / path)}

    def _lines(self) -> Reply:
        lines = []
        for node in CONFIGS:
            before = given_in(self._text, node)
            target = self._attached.get(node, f'/{node}')
            for name, value in self.settings.given(node).items():
                if before.get(name) != value:
                    lines.append(f'ros2 param set {target} {name} {shlex.quote(flow(value))}')
        return {'is': 'lines', 'text': '\n'.join(lines)}

    def _plane(self) -> Reply:
        view = self.bench.view
        if view is None:
            raise ValueError('plane: there is no picture')
        return {'is': 'plane', **plane_of(view.frame, self.settings.detector)}

    def work(self) -> bool:
        """Do non-urgent work for a moment; returns whether there is more to do."""
        return self.bench.catch_up() or self._labeling.work()

    def _survey(self) -> None:
        self._labeling.survey(self.settings)

    def _label(self, id: int, frame: int, u: int, v: int, width: int, height: int) -> None:
        """A click selects what the tracker sees there; a box stands for itself."""
        is_click = width <= 1 and height <= 1
        size = (0, 0) if is_click else (width, height)
        center = u + (width - 1) / 2, v + (height - 1) / 2
        self._labeling.mark(id, frame, Mark((*center, *size)))

    def _gone(self, id: int, frame: int) -> None:
        self._labeling.mark(id, frame, Mark(None))

    def _unlabel(self, id: int, frame: int) -> None:
        self._labeling.mark(id, frame, None)

    def _labels_at(self, frame: int) -> Reply:
        return {'is': 'labels', 'frame': frame, 'labels': self._labeling.at(frame)}

    def _load_labels(self, path: str) -> None:
        self._labeling.load(self._folder, path)

    def _save_labels(self, path: str, overwrite: bool) -> Reply:
        self._labeling.save(self._folder, path, overwrite=overwrite)
        return {'is': 'saved_labels', 'path': str(self._folder.root / path)}

    def _nodes(self) -> Reply:
        return {'is': 'nodes', 'nodes': self._running.link().nodes()}

    def _attach(self, node: str, to: str) -> None:
        """Tune a running node, starting from its values; empty for none."""
        if node not in CONFIGS:
            raise ValueError(f'node: expected one of {", ".join(CONFIGS)}, got {node!r}')
        self._attached.pop(node, None)
        if to:
            values = self._running.link().values(to)
            self.settings.adopt(node, values)
            self._samples_before = []
            self._attached[node] = to
            self.bench.configure()

    def _give(self, node: str, given: Mapping[str, Any]) -> None:
        """Send new values to a node that is being tuned.

        :raises ValueError: it refuses them.
        """
        changed = self.settings.difference(node, given)
        if changed:
            self._running.link().give(self._attached[node], changed)

    def _change(
        self,
        node: str,
        values: dict[str, Any],
        samples: tuple[Sample, ...],
        *,
        follows: bool = False,
    ) -> Reply:
        """Change some values; the answer gives the revision of pictures made with them."""
        before = self.settings.changes
        if node in self._attached:
            self._give(node, self.settings.checked(node, values))
        self.settings.change(node, values, follows=follows)
        if self.settings.changes > before:
            self._samples_before.append(self._samples)
        self._samples = samples
        self.bench.configure()
        return {'is': 'set', 'revision': self.settings.revision}
