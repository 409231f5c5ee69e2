"""The parameters of a running node, validated whenever they are set."""

from collections.abc import Callable
from collections.abc import Iterable
from collections.abc import Mapping
from collections.abc import Sequence
import contextlib
from functools import partial
import sys
import threading
from typing import Any
from typing import Generic
from typing import TypeVar

from rcl_interfaces.msg import FloatingPointRange
from rcl_interfaces.msg import IntegerRange
from rcl_interfaces.msg import ParameterDescriptor
from rcl_interfaces.msg import SetParametersResult
from rclpy.parameter import Parameter
from yaml import YAMLError

from colortrack_ros.files import MAX_PARAMS_FILE
from colortrack_ros.files import read_file
from colortrack_ros.node_kit.guarded import GuardedNode
from colortrack_ros.node_kit.runtime import params_files
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.parameters import build
from colortrack_ros.parameters import Config
from colortrack_ros.parameters import DOCUMENT
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import Spec
from colortrack_ros.parameters import USER
from colortrack_ros.parameters.owners import owners_in
from colortrack_ros.parameters.owners import untaken

Setup = TypeVar('Setup', bound=Config)
Build = Callable[[Mapping[str, Any]], Any]

LISTS = {
    bool: Parameter.Type.BOOL_ARRAY,
    int: Parameter.Type.INTEGER_ARRAY,
    float: Parameter.Type.DOUBLE_ARRAY,
    str: Parameter.Type.STRING_ARRAY,
}
"""Parameter type of a list, by the type of its items."""

FOREIGN = ('use_sim_time', 'qos_overrides.', 'start_type_description_service')
"""Names, or prefixes, of the parameters that rclpy itself declares."""

FOR = {USER: '', EXPERT: ' For experts.', DOCUMENT: ' Only to reproduce a document.'}
"""Suffix of a description, by audience."""


def descriptor_of(spec: Spec) -> ParameterDescriptor:
    """The descriptor that ``ros2 param describe`` shows."""
    descriptor = ParameterDescriptor(
        description=spec.description
        + (f' [{spec.unit}]' if spec.unit else '')
        + FOR[spec.audience],
        additional_constraints=spec.range_text,
        read_only=spec.read_only,
        # Spec checks types: it accepts 30 for 30.0 and says what it expected.
        dynamic_typing=True,
    )
    if spec.limits:
        low, high = spec.limits
        if type(spec.default) is float:
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=float(low), to_value=float(high))
            ]
        elif type(spec.default) is int:
            descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high))]
    return descriptor


class ParameterNode(GuardedNode, Generic[Setup]):
    """A node whose parameters are the fields of a configuration.

    An invalid value is refused, with the reason in the log (on start) or in the response (at run
    time), and the old value, on start the default, remains in force. With the parameter ``strict``
    the node does not start.

    :param name: of the node.
    :param config: declares the parameters.
    :param beside: configurations of the other nodes in the process, whose parameters are not
        refused.
    :ivar setup: the values in force.
    :ivar lock: held while parameters change, for code that must not see a partial change.
    :raises StartError: a value is refused, and ``strict`` is set.
    """

    _given: dict[str, Any] | None = None

    def __init__(
        self, name: str, config: type[Setup], beside: Iterable[type[Config]] = (), **options: Any
    ) -> None:
        super().__init__(
            name,
            allow_undeclared_parameters=True,  # so that parameters of a new NAME can be set
            automatically_declare_parameters_from_overrides=True,
            **options,
        )
        self.lock = threading.Lock()
        table, make = ParameterTable.of(config), partial(build, config)
        self._tell_of_other_owners()
        self._leave_to_others(table, [ParameterTable.of(other) for other in beside])
        values = self._declare_checked(table, make)
        self.setup: Setup = make(values)
        live = LiveParameters(table, make, self._take_setup, values)
        self.add_pre_set_parameters_callback(live.widen)
        self.add_on_set_parameters_callback(live.check)
        self.add_post_set_parameters_callback(live.take)

    def apply(self, setup: Setup) -> None:
        """Apply changed parameters; :attr:`setup` still holds the old ones."""

    def declare_parameters(
        self, namespace: str, parameters: Any, ignore_override: bool = False
    ) -> list[Parameter]:
        """Declare parameters as rclpy does, except those given on start, which are validated first.

        The first call comes from rclpy's constructor, with everything that the command line and
        YAML files give, including unknown names.
        """
        if self._given is None:
            self._given = {name: value for name, value, _ in parameters}
            return []
        return super().declare_parameters(namespace, parameters, ignore_override)

    def _tell_of_other_owners(self) -> None:
        """Say so when a params file means this node, but by another name than it has."""
        node = self.get_fully_qualified_name()
        for path in params_files(sys.argv):
            with contextlib.suppress(OSError, ValueError, YAMLError):  # rcl has taken it
                if others := untaken(owners_in(read_file(path, MAX_PARAMS_FILE)), node):
                    self.get_logger().warning(f'{path}: {others}')

    def _leave_to_others(self, table: ParameterTable, others: list[ParameterTable]) -> None:
        """Drop parameters of other nodes, which ``-p NAME:=VALUE`` or ``/**`` gives to all
        nodes.
        """
        given = self._given or {}
        theirs = [n for n in given if n not in table and any(n in other for other in others)]
        if theirs:
            self.get_logger().info(f'Parameters of other nodes: {", ".join(sorted(theirs))}.')
        self._given = {name: value for name, value in given.items() if name not in theirs}

    def _declare_checked(self, table: ParameterTable, make: Build) -> dict[str, Any]:
        """Declare the table's parameters; return their values."""
        given = {
            name: [] if value is None else value  # rcl cannot type an empty list
            for name, value in (self._given or {}).items()
            if not name.startswith(FOREIGN)
        }
        values, refused = table.consistent(given, make)
        for reason in refused.values():
            self.get_logger().error(f'Parameter refused: {reason}. The default stays in force.')
        if refused and values.get('strict'):
            raise StartError(
                f'strict: {len(refused)} refused on start, as said above; correct that'
            )
        for name, value in values.items():
            spec = table.find(name)
            self.declare_parameter(
                name, spec.shown(value), descriptor_of(spec), ignore_override=True
            )
            if value == []:
                self.set_parameters([Parameter(name, LISTS[spec.kind], [])])
        return values

    def _take_setup(self, setup: Setup) -> None:
        with self.lock:
            try:
                self.apply(setup)
            except Exception as error:  # such as a file that was deleted since the check
                self.get_logger().error(f'Parameters not taken into use: {error}')
                return
            self.setup = setup


class LiveParameters:
    """Callbacks of rclpy before, during, and after the setting of parameters.

    :param values: those in force.
    """

    def __init__(
        self,
        table: ParameterTable,
        build: Build,
        apply: Callable[[Any], object],
        values: Mapping[str, Any],
    ) -> None:
        self._table, self._build, self._apply = table, build, apply
        self._values = dict(values)

    def widen(self, parameters: list[Parameter]) -> list[Parameter]:
        """Convert an int to a float for a float parameter, before validation."""
        return [self._widened(parameter) for parameter in parameters]

    def check(self, parameters: list[Parameter]) -> SetParametersResult:
        """Accept or refuse a set of values as a whole, with the reason."""
        try:
            after = self._after(parameters)
            if after != self._values:
                self._build(self._table.defaults(after))
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        except Exception as error:  # no value may end the node
            return SetParametersResult(successful=False, reason=f'{type(error).__name__}: {error}')
        return SetParametersResult(successful=True)

    def take(self, parameters: list[Parameter]) -> None:
        """Apply the values that have been set."""
        after = self._after(parameters)
        if after != self._values:
            self._values = after
            self._apply(self._build(self._table.defaults(after)))

    def _widened(self, parameter: Parameter) -> Parameter:
        try:
            value = self._table.find(parameter.name).check(parameter.name, parameter.value)
        except ValueError:
            return parameter  # refused later, with its reason
        # rclpy cannot tell the type of an empty list.
        kind = LISTS[self._table.find(parameter.name).kind] if value == [] else None
        return Parameter(parameter.name, kind, value)

    def _after(self, parameters: Sequence[Parameter]) -> dict[str, Any]:
        """The values in force once these are set.

        :raises ValueError: one of them has no such name, type or range.
        """
        after = dict(self._values)
        for parameter in parameters:
            if parameter.name.startswith(FOREIGN):
                continue
            spec = self._table.find(parameter.name)
            if parameter.type_ != Parameter.Type.NOT_SET:
                after[parameter.name] = spec.check(parameter.name, parameter.value)
            elif parameter.name in self._table.specs and not spec.optional:
                raise ValueError(
                    f'{parameter.name}: cannot be deleted; expected a {spec.type_name}'
                )
            else:
                after.pop(parameter.name, None)
        return after
