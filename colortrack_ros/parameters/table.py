"""The parameters of one kind of node, by their full names.

The table validates the type and range of each value. Whether values contradict each other is
checked by the configuration built from them, which raises ValueError with the reason.
"""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
import difflib
from typing import Any

from colortrack_ros.parameters.config import Config
from colortrack_ros.parameters.config import groups_of
from colortrack_ros.parameters.config import specs_of
from colortrack_ros.parameters.spec import Spec


class ParameterTable:
    """The parameters of one kind of node.

    :param specs: parameters that always exist.
    :param each: for each parameter that lists names, the parameters ``NAME.spec`` of each NAME in
        it.
    """

    def __init__(
        self, specs: Iterable[Spec], each: Mapping[str, Iterable[Spec]] | None = None
    ) -> None:
        self.specs = {spec.name: spec for spec in specs}
        self.groups = {names: {s.name: s for s in group} for names, group in (each or {}).items()}
        self.each = {name: spec for group in self.groups.values() for name, spec in group.items()}

    @classmethod
    def of(cls, config: type[Config]) -> 'ParameterTable':
        """The table of the parameters that a configuration declares."""
        return cls(
            specs_of(config), {name: specs_of(group.each) for name, group in groups_of(config)}
        )

    def __contains__(self, name: str) -> bool:
        """Whether there is a parameter of this full name."""
        owner, _, suffix = name.rpartition('.')
        return name in self.specs or (owner != '' and suffix in self.each)

    def find(self, name: str) -> Spec:
        """The declaration of a parameter.

        :param name: full.
        :raises ValueError: there is none; the reason suggests the nearest name.
        """
        owner, _, suffix = name.rpartition('.')
        if name not in self:
            known = [*self.specs, *(f'{owner or "NAME"}.{suffix}' for suffix in self.each)]
            near = difflib.get_close_matches(name, known, n=1, cutoff=0.0)[0]
            raise ValueError(f'{name}: no such parameter; the nearest is {near}')
        return self.specs.get(name) or self.each[suffix]

    def defaults(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The given values, and defaults for all others."""
        every = dict(self.specs)
        for listing, group in self.groups.items():
            names = values.get(listing, self.specs[listing].default)
            if not self.specs[listing].optional or listing in values:
                every |= {f'{name}.{key}': spec for name in names for key, spec in group.items()}
        return {n: s.default for n, s in every.items() if not s.optional} | dict(values)

    def consistent(
        self, given: Mapping[str, Any], build: Callable[[Mapping[str, Any]], Any]
    ) -> tuple[dict[str, Any], dict[str, str]]:
        """The largest set of given values that are valid together, and why the others are not.

        :param given: from the command line and YAML files.
        :param build: raises ValueError if values contradict each other.
        :return: all values, including defaults; and the reason for each refused name.
        """
        accepted: dict[str, Any] = {}
        refused: dict[str, str] = {}
        for name, value in given.items():
            try:
                accepted[name] = self.find(name).check(name, value)
            except ValueError as error:
                refused[name] = str(error)
        try:
            build(self.defaults(accepted))
        except ValueError:
            accepted, reasons = self._largest_consistent(accepted, build)
            refused.update(reasons)
        return self.defaults(accepted), refused

    def _largest_consistent(
        self, given: Mapping[str, Any], build: Callable[[Mapping[str, Any]], Any]
    ) -> tuple[dict[str, Any], dict[str, str]]:
        accepted: dict[str, Any] = {}
        waiting = dict(given)
        while True:
            reasons = {}
            for name, value in waiting.items():
                try:
                    build(self.defaults(accepted | {name: value}))
                    accepted[name] = value
                except ValueError as error:
                    reasons[name] = str(error)
            # One value may be valid only with another, so retry as long as that helps.
            if len(reasons) in (0, len(waiting)):
                return accepted, reasons
            waiting = {name: waiting[name] for name in reasons}
