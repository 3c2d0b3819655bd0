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

"""The parameters of another node: described, read, followed and set, as any client may."""
from collections.abc import Callable, Mapping
import time

from flag_sim.parameters.descriptor import described, Descriptor
from flag_sim.ros.guard import GuardedNode
from rcl_interfaces.msg import Parameter, ParameterDescriptor, ParameterEvent, ParameterType
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.parameter import parameter_value_to_python

PATIENCE = 3.0
"""How long a service may take to answer [s]."""
KINDS = {
    ParameterType.PARAMETER_BOOL: 'bool', ParameterType.PARAMETER_INTEGER: 'int',
    ParameterType.PARAMETER_DOUBLE: 'float', ParameterType.PARAMETER_STRING: 'str',
    ParameterType.PARAMETER_BOOL_ARRAY: 'bools', ParameterType.PARAMETER_INTEGER_ARRAY: 'ints',
    ParameterType.PARAMETER_DOUBLE_ARRAY: 'floats', ParameterType.PARAMETER_STRING_ARRAY: 'strs',
}
"""The kind of a Descriptor, by the type of a ParameterValue."""
FIELDS = {
    'bool': ('bool_value', bool), 'int': ('integer_value', int), 'float': ('double_value', float),
    'str': ('string_value', str), 'bools': ('bool_array_value', bool),
    'ints': ('integer_array_value', int), 'floats': ('double_array_value', float),
    'strs': ('string_array_value', str),
}
"""The field of a ParameterValue that holds a kind, and the type of what it holds."""
TYPES = {kind: number for number, kind in KINDS.items()}
UNKNOWN_KINDS = {bool: 'bool', int: 'int', float: 'float', str: 'str'}


def to_value(value: object, kind: str) -> ParameterValue:
    """
    Return the ParameterValue of a value; None is no value, which deletes a parameter.

    kind: as of a Descriptor; of another one it is that of the value. Raises ValueError for a value
    that is not of its kind.
    """
    if value is None:
        return ParameterValue(type=ParameterType.PARAMETER_NOT_SET)
    if kind not in FIELDS:
        one = (value[0] if value else '') if isinstance(value, list) else value
        kind = UNKNOWN_KINDS.get(type(one), 'str') + 's' * isinstance(value, list)
    field, item = FIELDS[kind]
    try:
        ones = [item(one) for one in value] if kind.endswith('s') else [item(value)]
        if item is int and (any(abs(one) >= 2**63 for one in ones)
                            or ones != (value if kind.endswith('s') else [value])):
            raise ValueError
        held = ones if kind.endswith('s') else ones[0]
        return ParameterValue(type=TYPES[kind], **{field: held})
    except (TypeError, ValueError, AssertionError, OverflowError):
        raise ValueError(f'{value!r} is no {kind}') from None


def to_descriptor(message: ParameterDescriptor, value: ParameterValue) -> Descriptor:
    """Return what a node tells of a parameter."""
    limits = None, None
    for one in (*message.floating_point_range, *message.integer_range):
        limits = one.from_value, one.to_value
    return described(message.name, KINDS.get(value.type, 'other'), message.description,
                     message.additional_constraints, limits, message.read_only)


def to_python(value: ParameterValue) -> object:
    """Return the value as Python's own; None where it is of a type that ROS does not know."""
    try:
        value = parameter_value_to_python(value)
    except RuntimeError:
        return None
    return value.tolist() if hasattr(value, 'tolist') else value


class RemoteNode:
    """
    What is known of the node `name` and what it is asked.

    on_described(descriptors, values): it has told all its parameters. on_changed(values, deleted):
    some have been set, by whomever. Call `look` often: it asks until there is an answer, and gives
    up what has not been answered within PATIENCE; call `take_event` with every event of the node.
    """

    def __init__(self, node: GuardedNode, name: str, on_described: Callable,
                 on_changed: Callable):
        self.name = name
        self._node = node
        self._on_described = on_described
        self._on_changed = on_changed
        self._clients = {kind: node.create_client(kind, f'{name}/{service}') for kind, service in (
            (ListParameters, 'list_parameters'), (DescribeParameters, 'describe_parameters'),
            (GetParameters, 'get_parameters'), (SetParameters, 'set_parameters'),
            (SetParametersAtomically, 'set_parameters_atomically'))}
        self._pending = {}  # {future: (service, until when it may answer [s], what gives it up)}
        self._heard = {}    # what events have said since the node was asked
        self._names = None  # of all its parameters; None before they are known
        self._is_learning = False

    def look(self) -> None:
        """Ask what is not known, and give up what was not answered in time."""
        now = time.monotonic()
        late = [one for one, (_, until, _) in self._pending.items() if now > until]
        for future in late:
            service, _, give_up = self._pending.pop(future)
            self._clients[service].remove_pending_request(future)
            give_up()
        if self._names is None and not self._is_learning:
            self._learn()

    def close(self) -> None:
        """Forget the node, and give up what it has not answered."""
        pending = [*self._pending.values()]
        self._pending.clear()
        for _, _, give_up in pending:
            give_up()
        for client in self._clients.values():
            self._node.destroy_client(client)

    def take_event(self, event: ParameterEvent) -> None:
        """Take what the node says on /parameter_events."""
        values = {one.name: to_python(one.value)
                  for one in (*event.new_parameters, *event.changed_parameters)}
        deleted = tuple(one.name for one in event.deleted_parameters)
        self._heard.update({**values, **dict.fromkeys(deleted)})
        if self._names is not None:
            self._names |= values.keys()
            self._on_changed(values, deleted)

    def put(self, values: Mapping, kinds: Mapping, together: bool, on_answer: Callable) -> None:
        """
        Set {name: value}, None to delete; together: all of them or none.

        kinds: {name: kind of its Descriptor}. on_answer: called once with {name: why it was
        refused, or ''}.
        """
        parameters = []
        for name, value in values.items():
            try:
                parameters.append(Parameter(name=name, value=to_value(value, kinds.get(name, ''))))
            except ValueError as error:
                on_answer(dict.fromkeys(values, f'{name}: {error}'))
                return
        kind = SetParametersAtomically if together else SetParameters

        def answer(response):
            results = [response.result] * len(values) if together else response.results
            on_answer({name: '' if result.successful else result.reason or 'refused'
                       for name, result in zip(values, results)})
        self._call(kind, kind.Request(parameters=parameters), answer, lambda: on_answer(
            dict.fromkeys(values, f'{self.name} did not answer within {PATIENCE:g} s')))

    def _call(self, kind, request, on_answer, give_up):
        future = self._clients[kind].call_async(request)
        self._pending[future] = kind, time.monotonic() + PATIENCE, give_up
        future.add_done_callback(self._node.guarded(lambda done: self._take(done, on_answer)))

    def _take(self, future, on_answer):
        if self._pending.pop(future, None) is not None:  # else it came too late
            on_answer(future.result())

    # Learning: the names, then what describes them, then the values.

    def _learn(self):
        if not self._clients[ListParameters].service_is_ready():
            return
        self._is_learning = True
        self._heard = {}
        self._call(ListParameters, ListParameters.Request(), self._describe, self._give_up)

    def _give_up(self):
        self._is_learning = False  # the next look asks again

    def _describe(self, answer):
        names = sorted(answer.result.names)
        self._call(DescribeParameters, DescribeParameters.Request(names=names),
                   lambda descriptors: self._read(names, descriptors.descriptors), self._give_up)

    def _read(self, names, descriptors):
        self._call(GetParameters, GetParameters.Request(names=names),
                   lambda answer: self._finish(names, descriptors, answer.values), self._give_up)

    def _finish(self, names, descriptors, values):
        self._is_learning = False
        if not len(names) == len(descriptors) == len(values):  # some were deleted meanwhile
            return
        self._names = set(names)
        for name, descriptor in zip(names, descriptors):
            descriptor.name = name
        read = dict(zip(names, map(to_python, values)))
        # What was heard meanwhile is not older than the answer.
        read = {name: value for name, value in {**read, **self._heard}.items()
                if value is not None}
        self._on_described(
            tuple(to_descriptor(*one) for one in zip(descriptors, values)), read)
