"""The parameters of a running node, checked whenever somebody sets them."""

from collections.abc import Callable
from collections.abc import Mapping
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

from rcl_interfaces.msg import FloatingPointRange
from rcl_interfaces.msg import IntegerRange
from rcl_interfaces.msg import ParameterDescriptor
from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from colortrack_ros.parameters import DOCUMENT
from colortrack_ros.parameters import EXPERT
from colortrack_ros.parameters import ParameterTable
from colortrack_ros.parameters import Spec
from colortrack_ros.parameters import USER

Build = Callable[[Mapping[str, Any]], Any]

FOREIGN = ('use_sim_time', 'qos_overrides.', 'start_type_description_service')
"""Names (or their beginnings) of the parameters that rclpy declares on its own."""


FOR = {USER: '', EXPERT: ' For experts.', DOCUMENT: ' Only to reproduce a document.'}
"""What a description ends with, by the audience."""


def own_values(setup: type, values: Mapping[str, Any]) -> dict[str, Any]:
    """Of the parameters those that a setup, a dataclass, has as fields of the same name."""
    return {field.name: values[field.name] for field in fields(setup) if field.name in values}


def descriptor_of(spec: Spec) -> ParameterDescriptor:
    """What ``ros2 param describe`` shows."""
    descriptor = ParameterDescriptor(
        description=spec.description
        + (f' [{spec.unit}]' if spec.unit else '')
        + FOR[spec.audience],
        additional_constraints=spec.range_text,
        read_only=spec.read_only,
        # The types are checked here, so that 30 is taken for 30.0 and the reason is ours.
        dynamic_typing=True,
    )
    if spec.minimum is not None and spec.maximum is not None:
        low, high = spec.minimum, spec.maximum
        if type(spec.default) is float:
            descriptor.floating_point_range = [
                FloatingPointRange(from_value=float(low), to_value=float(high))
            ]
        elif type(spec.default) is int:
            descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high))]
    return descriptor


def declare(node: Node, table: ParameterTable, build: Build, apply: Callable[[Any], object]) -> Any:
    """Declare the table's parameters, check them now and whenever somebody sets them.

    A bad value is refused with its reason in the log (on start) or in the answer (at run time), and
    the old one, on start the default, stays in force. The node has to allow undeclared parameters,
    so that those of a new NAME can be set.

    :param build: makes the configuration from all values, raises ValueError with a reason.
    :param apply: takes a configuration into use, when somebody has changed a parameter.
    :return: the configuration to start with.
    """
    # rclpy has no public way to see the overrides of names that are not declared.
    overrides = {
        name: override.value
        for name, override in node._parameter_overrides.items()
        if not name.startswith(FOREIGN)
    }
    values, refused = table.consistent(overrides, build)
    for reason in refused.values():
        node.get_logger().error(f'Parameter refused: {reason}. The default stays in force.')
    for name, value in values.items():
        spec = table.find(name)
        node.declare_parameter(name, spec.shown(value), descriptor_of(spec), ignore_override=True)
    live = LiveParameters(table, build, apply, values)
    node.add_pre_set_parameters_callback(live.widen)
    node.add_on_set_parameters_callback(live.check)
    node.add_post_set_parameters_callback(live.take)
    return build(values)


class LiveParameters:
    """What rclpy asks before, while and after parameters are set.

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
        """An int where a float is meant is taken as the float, before anybody looks at it."""
        return [self._widened(parameter) for parameter in parameters]

    def check(self, parameters: list[Parameter]) -> SetParametersResult:
        """Refuse a set of values as a whole, with a reason."""
        try:
            after = self._after(parameters)
            if after != self._values:
                self._build(self._table.defaults(after))
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def take(self, parameters: list[Parameter]) -> None:
        """Take values that have been set into use."""
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
        return parameter if value == [] else Parameter(parameter.name, value=value)

    def _after(self, parameters: Sequence[Parameter]) -> dict[str, Any]:
        """The values in force when these have been set.

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
