# Copyright 2026 The flag_sim Authors
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""A ROS node whose parameters are declared, checked and refused in one place."""
import difflib

from flag_sim.declarations.nodes import NODES, scene
from flag_sim.parameters import checks
from flag_sim.protocol.stopwatch import Stopwatch
from flag_sim.protocol.throttled_log import shortened
from flag_sim.ros.guard import cause, GuardedNode
from flag_sim.ros.node_log import NodeLog
from flag_sim.ros.parameter_service import CheckedParameterService
from flag_sim.ros.qos_overrides import ignored_overrides, PREFIX
from rcl_interfaces.msg import FloatingPointRange, IntegerRange
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.parameter import Parameter
from rclpy.task import Future

ARRAY_TYPES = {str: Parameter.Type.STRING_ARRAY, float: Parameter.Type.DOUBLE_ARRAY,
               bool: Parameter.Type.BOOL_ARRAY}
# Names that rclpy itself declares and reads, beside QoS overrides.
ROS_NAMES = ('use_sim_time', 'start_type_description_service')

LONGEST_NAME = 200
"""Of a name for which a near one is looked for; all of ours are shorter [characters]."""


class BadParameter(ValueError):
    """A node cannot start with the parameters that it was given; the message is for the user."""


class ParameterNode(GuardedNode):
    """
    A node with the parameters of `declarations`.

    A value is refused with the rule and the value: at the start by BadParameter, while running by
    the result of the service. rclpy's own check of a descriptor's range names neither, and its
    callbacks run only after that check; hence the checks stand before it, in
    `set_parameters_atomically`, through which every way of setting a parameter goes.
    """

    def __init__(self, name, declarations, **options):
        try:
            super().__init__(name, start_parameter_services=False, **options)
        except InvalidParameterTypeException:  # of those that rclpy declares, all of them booleans
            raise BadParameter(self._mistyped()) from None
        self._log = NodeLog(self)
        # One for all: the EventsExecutor has a thread for every clock.
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.ended = Future()  # set to the exit status when the node has nothing left to do
        self._stopwatch = Stopwatch()
        self._declarations = {declaration.name: declaration for declaration in declarations}
        self.values = {}
        self._declare()
        self._parameter_service = CheckedParameterService(self, self.is_part)

    def _mistyped(self):
        """Return what is wrong with the parameters of ROS that were given at the start."""
        return '; '.join(f'{name} must be a boolean, not {checks.shown(given.value)}'
                         for name, given in self._parameter_overrides.items()
                         if name in ROS_NAMES and not isinstance(given.value, bool))

    @property
    def figures(self):
        """Return how many frames were served, and where the time went: see Stopwatch."""
        return self._stopwatch.figures()

    def create_timer(self, timer_period_sec, callback, callback_group=None, clock=None, **options):
        """
        Return a timer, of a steady clock unless another is given.

        Only frames follow simulation time. Resending and reports are about real time: with
        use_sim_time rclpy's own timers would stop with the simulation.
        """
        return super().create_timer(
            timer_period_sec, callback, callback_group,
            clock or self._steady, **options)

    def _declare(self):
        # rclpy's private record of what was given at the start: its public way, to declare all
        # of it automatically, ends in a traceback for an empty list, whose type is not set.
        given = {name: [] if parameter.value is None else parameter.value
                 for name, parameter in self._parameter_overrides.items()}
        try:
            for declaration in self._declarations.values():
                self.values[declaration.name] = self.accept(
                    declaration.name, given.pop(declaration.name, declaration.default))
                self._declare_one(declaration.name, declaration.item, _descriptor(declaration))
            self.adopt(given)
            self.check(self.values)
        except ValueError as error:
            raise BadParameter(shortened(str(error))) from None
        for name in given:
            if name not in ROS_NAMES and not name.startswith(PREFIX):
                self._warn_of(name)

    def _declare_one(self, name, item, descriptor):
        value = self.values[name]
        if value == []:  # of which rclpy cannot tell the type
            parameter = to_parameter(name, value, item)
            self.declare_parameter(name, parameter.type_, descriptor, ignore_override=True)
            self.store([parameter])
        else:
            self.declare_parameter(name, value, descriptor, ignore_override=True)

    def _warn_of(self, name):
        """Warn of a name that no node reads; rclpy would ignore it silently."""
        if name in {declaration.name for declaration in scene()}:
            return  # shared parameters are given to all nodes by '/**'
        for node, declarations in NODES.items():
            if name in {declaration.name for declaration in declarations}:
                self.get_logger().warning(f"parameter '{name}' is one of /{node}, not of "
                                          f'/{self.get_name()}: it is ignored')
                return
        self.get_logger().warning(f"parameter '{name}' is unknown and ignored{self._near(name)}")

    def tell_of_ignored(self):
        """Warn of QoS overrides that nothing takes; call it once the node has all its topics."""
        for words in ignored_overrides(self):
            self.get_logger().warning(words)

    def _near(self, name):
        # Comparing takes a while, and no name of ours is long.
        near = difflib.get_close_matches(name[:LONGEST_NAME], self._declarations, n=1)
        return f"; the nearest known one is '{near[0]}'" if near else ''

    def is_part(self, name):
        """Return whether a parameter is set together with others in a request, all or none."""
        return False

    def adopt(self, given):
        """Take from `given` {name: value} undeclared names; what is left is warned of."""

    def accept(self, name, value):
        """Return `value` as parameter `name` would hold it; raise ValueError if it may not."""
        if name not in self._declarations:
            raise ValueError(f"no parameter '{name}'{self._near(name)}")
        return self._declarations[name].accept(value)

    def item_of(self, name):
        """Return the type of what the list of parameter `name` holds, which an empty one hides."""
        return self._declarations[name].item if name in self._declarations else str

    def check_deletion(self, name):
        """Raise ValueError unless parameter `name` may be deleted."""
        if not name.startswith(PREFIX):
            self.accept(name, self.values.get(name))  # no such name is told first
        raise ValueError(f'{name} cannot be deleted: /{self.get_name()} always has it')

    def check(self, values):
        """Raise ValueError if `values` {name: value} cannot stand together; no side effects."""

    def check_asked(self, changes):
        """Raise ValueError if what a user sets, {name: value}, cannot be had now."""

    def apply(self, changed):
        """Let the new values of the names in `changed` count."""

    def set_parameters(self, parameter_list):
        """Set each of the parameters that may be set; rclpy's own bypasses the checks below."""
        return [self.set_parameters_atomically([parameter]) for parameter in parameter_list]

    def set_parameters_atomically(self, parameter_list):
        """Set all of the parameters or, with the reason, none."""
        # Of several values of one parameter the last one counts.
        parameter_list = list({p.name: p for p in parameter_list}.values())
        own = [p for p in parameter_list if p.name not in ROS_NAMES]
        deleted = {p.name for p in own if p.type_ == Parameter.Type.NOT_SET}
        try:
            for name in deleted:
                self.check_deletion(name)
            changes = {p.name: self.accept_change(p.name, p.value) for p in own
                       if p.name not in deleted}
            self.check_asked(changes)
            self.check({name: value for name, value in {**self.values, **changes}.items()
                        if name not in deleted})
        except ValueError as error:
            return SetParametersResult(successful=False, reason=shortened(str(error)))
        result = self.store([self._typed(p, changes) for p in parameter_list])
        if result.successful:
            self.values.update(changes)
            for name in deleted:
                del self.values[name]
            self.apply({*changes, *deleted})
        return result

    def store(self, parameters):
        """Set parameters as rclpy does, without the checks; return its result."""
        try:
            return super().set_parameters_atomically(parameters)
        except RuntimeError as error:  # of the middleware: all is set when it is announced
            self._log.warn(f'a change of parameters could not be announced: {cause(error)}')
            return SetParametersResult(successful=True)

    def accept_change(self, name, value):
        """Return `value` as accept does; raise ValueError also where only the start counts."""
        is_override = name.startswith(PREFIX)
        accepted = None if is_override else self.accept(name, value)
        if is_override or (name in self._declarations and self._declarations[name].fixed):
            raise ValueError(f'{name} is fixed at the start of the node')
        return accepted

    def _typed(self, parameter, changes):
        if parameter.name not in changes:
            return parameter
        return to_parameter(parameter.name, changes[parameter.name], self.item_of(parameter.name))


def to_parameter(name, value, item=str):
    """Return the rclpy Parameter of a value; an empty list is one of `item`."""
    if isinstance(value, list):
        item = type(value[0]) if value else item
        return Parameter(name, ARRAY_TYPES[item], value)
    return Parameter(name, value=value)


def _descriptor(declaration):
    unit = f' [{declaration.unit}]' if declaration.unit else ''
    descriptor = ParameterDescriptor(description=declaration.effect + unit)
    descriptor.additional_constraints = f'must be {declaration.rule}'
    descriptor.read_only = declaration.fixed
    if declaration.low is not None and isinstance(declaration.default, float):
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=declaration.low, to_value=declaration.high)]
    elif declaration.low is not None and isinstance(declaration.default, int):
        descriptor.integer_range = [
            IntegerRange(from_value=declaration.low, to_value=declaration.high, step=1)]
    return descriptor
