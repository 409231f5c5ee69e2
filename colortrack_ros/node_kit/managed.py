"""Nodes that a lifecycle manager, such as Nav2's, can configure, activate, and shut down."""

from collections.abc import Iterable
from typing import Any
from typing import TypeVar

from rclpy.lifecycle import LifecycleNodeMixin
from rclpy.lifecycle import LifecycleState
from rclpy.lifecycle import TransitionCallbackReturn

from colortrack_ros.node_kit.live_parameters import ParameterNode
from colortrack_ros.node_kit.node_setup import NodeSetup
from colortrack_ros.node_kit.runtime import plan_of
from colortrack_ros.node_kit.runtime import StartError
from colortrack_ros.parameters import Config

Setup = TypeVar('Setup', bound=NodeSetup)

CONFIGURED_AGAIN = 'the node was configured again'
"""Why a tracker restarts that a node has kept: others may still know its tracks and markers."""


class ManagedNode(LifecycleNodeMixin, ParameterNode[Setup]):
    """A node with the states of https://design.ros2.org/articles/node_lifecycle.html.

    Unconfigured, it has only its parameters. Inactive, it also has its topics and services but
    drops its input. With the parameter ``autostart`` it is active from the start.

    A subclass implements :meth:`configure`, :meth:`set_active`, and, if it has more than topics and
    services, :meth:`release`.

    :ivar active: whether it is active.
    :ivar configured_before: whether it has been configured, and cleaned up since.
    """

    def __init__(
        self, name: str, config: type[Setup], beside: Iterable[type[Config]] = (), **options: Any
    ) -> None:
        ParameterNode.__init__(self, name, config, beside, **options)
        LifecycleNodeMixin.__init__(self)
        self.active = self._configured = self._starting = self.configured_before = False
        self._failure = ''
        self._before: set[Any] = set()
        change = self._service_change_state.callback
        self._service_change_state.callback = lambda *call: self._answer(change, *call)

    def configure(self) -> None:
        """Create all publishers, subscriptions, services and so on.

        :raises StartError: this is not possible.
        """

    def set_active(self, active: bool) -> None:
        """Start processing input, or drop it from now on; called whenever :attr:`active`
        changes.
        """

    def release(self) -> None:
        """Release everything that is neither topic nor service, such as a device."""

    def start(self) -> None:
        """Become active, if ``autostart`` is set.

        :raises StartError: the node cannot be configured.
        """
        if not self.setup.autostart:
            self.get_logger().info('autostart is false: waits for a lifecycle manager')
            return
        self._starting = True
        if self.trigger_configure() != TransitionCallbackReturn.SUCCESS:
            raise StartError(self._failure)
        self._starting = False
        self.trigger_activate()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Configure; if this fails, the node stays unconfigured."""
        self._before = self._ends()
        try:
            self.configure()
        except Exception as error:  # a failed transition must not end the node
            self._failure = ' '.join(str(error).split()) or type(error).__name__
            if not self._starting:  # then it ends the node, which logs it
                self.get_logger().error(f'Not configured: {self._failure}')
            self._unmake()
            return TransitionCallbackReturn.FAILURE
        self._configured = self.configured_before = True
        self.get_logger().info(plan_of(self))
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Activate."""
        self._switch(active=True)
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Deactivate."""
        self._switch(active=False)
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Clean up: only the parameters remain."""
        self._clean_up()
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Shut down: only the parameters remain, for good."""
        self._clean_up()
        return TransitionCallbackReturn.SUCCESS

    def close(self) -> None:
        """Release everything, at the end of the process."""
        if self._configured:
            self._switch(active=False)
            self.release()

    def _switch(self, *, active: bool) -> None:
        self.active = active
        self.set_active(active)

    def _clean_up(self) -> None:
        if self._configured:
            self._configured = False
            self._switch(active=False)
            self.release()
            self._unmake()

    def _ends(self) -> set[Any]:
        """The existing publishers, subscriptions and so on."""
        kinds = self.publishers, self.subscriptions, self.services, self.clients, self.timers
        return {end for kind in kinds for end in kind}

    def _unmake(self) -> None:
        """Destroy everything that was created since the node was configured."""
        made = self._ends() - self._before
        for kind in ('publisher', 'subscription', 'service', 'client', 'timer'):
            for end in made & set(getattr(self, f'{kind}s')):
                getattr(self, f'destroy_{kind}')(end)

    def _take_setup(self, setup: Setup) -> None:
        if self._configured:
            super()._take_setup(setup)
        else:
            self.setup = setup

    def _answer(self, change: Any, request: Any, response: Any) -> Any:
        """Answer a call of change_state; rclpy raises for unknown transitions."""
        try:
            return change(request, response)
        except Exception as error:
            self.get_logger().warning(f'Refused: {" ".join(str(error).split())}')
            response.success = False
            return response
