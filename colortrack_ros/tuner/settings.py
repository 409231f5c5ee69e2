"""The parameters of detector and tracker while they are being tuned."""

from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from typing import Any

from colortrack_ros.detection import DetectorConfig
from colortrack_ros.detection.regions import Regions
from colortrack_ros.parameters import build
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import Spec
from colortrack_ros.parameters.params_file import given_in
from colortrack_ros.parameters.params_file import with_values
from colortrack_ros.tracking import TrackerConfig

CONFIGS = {'detector': DetectorConfig, 'tracker': TrackerConfig}
"""Configurations by the name of the node."""

TUNED = {node: ParameterTable.of(config) for node, config in CONFIGS.items()}

Values = dict[str, dict[str, Any]]
"""Values that were given or differ from the defaults, by node and full name."""


class Settings:
    """The values given to each node, and the configurations built from them.

    :param text: of a params file; empty for the defaults.
    :ivar refused: why values of the file are not in force, by node and name.
    :ivar revision: incremented with every change, and stored with each picture.
    :raises ValueError: the text is not a params file.
    """

    def __init__(self, text: str = '') -> None:
        self.refused: dict[str, str] = {}
        self.revision = 0
        self._before: list[Values] = []
        self._given: Values = {}
        self._configs: dict[str, Any] = {}
        for node, table in TUNED.items():
            given = {k: v for k, v in given_in(text, node).items() if k in table}
            accepted, refused = table.consistent(given, partial(_config, node))
            self.refused.update({f'{node}.{name}': why for name, why in refused.items()})
            self._given[node] = {k: v for k, v in accepted.items() if k in given}
            self._configs[node] = _config(node, self._given[node])

    @property
    def detector(self) -> DetectorConfig:
        """The configuration of the detector."""
        config: DetectorConfig = self._configs['detector']
        return config

    @property
    def tracker(self) -> TrackerConfig:
        """The configuration of the tracker."""
        config: TrackerConfig = self._configs['tracker']
        return config

    def given(self, node: str) -> Mapping[str, Any]:
        """The values that are given to a node, by full name."""
        return self._given[node]

    def checked(self, node: str, values: Mapping[str, Any]) -> dict[str, Any]:
        """The values given to a node after a change.

        :param values: by full name; None resets a value to the default.
        :raises ValueError: a value is refused, with the reason that the node would give.
        """
        return self._built(node, values)[0]

    def _built(self, node: str, values: Mapping[str, Any]) -> tuple[dict[str, Any], Any]:
        """What :meth:`checked` returns, and the configuration built from it."""
        if node not in TUNED:
            raise ValueError(f'node: expected one of {", ".join(TUNED)}, got {node!r}')
        table, given = TUNED[node], dict(self._given[node])
        for name, value in values.items():
            spec = table.find(name)
            if value is None:
                given.pop(name, None)
            else:
                given[name] = spec.check(name, value)
        return given, _config(node, given)

    def change(self, node: str, values: Mapping[str, Any], *, follows: bool = False) -> None:
        """Give a node some values, all or none of them.

        :param values: as for :meth:`checked`, which raises the same.
        :param follows: whether this continues the last change, like the next position of a slider:
            both are undone together.
        """
        given, config = self._built(node, values)
        if not (follows and self._before):
            self._before.append(self._given)
        self._given = {**self._given, node: given}
        self._configs[node] = config
        self.revision += 1

    def adopt(self, node: str, values: Mapping[str, Any]) -> None:
        """Take over the values of a running node, except defaults.

        This cannot be undone, since the node would have to follow.
        """
        table = TUNED[node]
        known = {name: value for name, value in values.items() if name in table}
        defaults = table.defaults({k: v for k, v in known.items() if k in table.groups})
        given = {k: v for k, v in known.items() if k not in defaults or defaults[k] != v}
        given |= {k: v for k, v in known.items() if k in table.groups}
        self.change(node, {**dict.fromkeys(self._given[node]), **given})
        self._before = []

    def before(self, node: str) -> Mapping[str, Any]:
        """The values given to a node before the last change.

        :raises ValueError: there was none.
        """
        if not self._before:
            raise ValueError('undo: there is nothing to take back')
        return self._before[-1][node]

    def difference(self, node: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """The values that a running node has to set to go from the current state to another.

        :returns: values by full name; None for one that becomes absent.
        """
        table, now = TUNED[node], self._given[node]
        changed = {k: v for k, v in given.items() if k not in now or now[k] != v}
        for name in now.keys() - given.keys():
            spec = table.specs.get(name)
            changed[name] = None if spec is None or spec.optional else spec.default
        return changed

    def undo(self) -> None:
        """Undo the last change.

        :raises ValueError: there is none.
        """
        if not self._before:
            raise ValueError('undo: there is nothing to take back')
        self._given = self._before.pop()
        self._configs = {node: _config(node, given) for node, given in self._given.items()}
        self.revision += 1

    @property
    def changes(self) -> int:
        """How many changes can be undone."""
        return len(self._before)

    def written_into(self, text: str) -> str:
        """The text of a params file with these values, and nothing else changed.

        :raises ValueError: the text is not a params file that can be edited in place.
        """
        for node, table in TUNED.items():
            old = {k: v for k, v in given_in(text, node).items() if k in table}
            new = self._given[node]
            gone = {name: None for name in old if name not in new}
            changed = {k: v for k, v in new.items() if k not in old or old[k] != v}
            if gone or changed:
                text = with_values(text, node, gone | changed)
        return text

    def in_force(self, node: str) -> dict[str, Any]:
        """All values, including defaults, by full name."""
        return TUNED[node].defaults(self._given[node])


def _config(node: str, given: Mapping[str, Any]) -> Any:
    """The configuration built from the given values.

    :raises ValueError: it is refused.
    """
    config: Any = build(CONFIGS[node], TUNED[node].defaults(given))
    if node == 'detector':
        Regions(config.regions, config.mask)
    return config


def described() -> dict[str, Any]:
    """The available parameters: for each node, its own and those of each NAME in a list."""
    return {
        node: {
            'parameters': [_description(spec) for spec in table.specs.values()],
            'each': {
                listing: [_description(spec) for spec in group.values()]
                for listing, group in table.groups.items()
            },
        }
        for node, table in TUNED.items()
    }


def _description(spec: Spec) -> dict[str, Any]:
    """A parameter in the form that the page needs."""
    shown = ('name', 'description', 'unit', 'limits', 'choices', 'length', 'audience')
    return {key: getattr(spec, key) for key in shown} | {
        'type': spec.type_name,
        'many': spec.many,
        'optional': spec.optional,
        'default': None if spec.optional else spec.default,
    }


def colors_of(config: DetectorConfig) -> list[dict[str, Any]]:
    """The reference colors, for display."""
    return [
        asdict(color) | {'axes': color.axes, 'sought': color.is_sought} for color in config.colors
    ]
