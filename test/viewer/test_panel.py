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

"""The panel on a model of its own, without nodes."""
from flag_sim.parameters.descriptor import Descriptor
from flag_sim.viewer.exchange import Described, Found
from flag_sim.viewer.graph_model import GraphModel
from flag_sim.viewer.panel import Panel
from support.window import application


def test_hundreds_of_parameters_are_shown():
    """Of a node that nobody knows, with names of all kinds; no two of them are mixed up."""
    application()
    model = GraphModel(lambda _: None)
    panel = Panel(model)
    descriptors = tuple(Descriptor(f'group{n % 7}.value{n}', 'float', low=0.0, high=1.0)
                        for n in range(400)) + (
        Descriptor('odd', 'other'), Descriptor('many', 'floats'), Descriptor('words', 'strs'))
    model.take(Found({'wind': '/stranger'}))
    model.take(Described('/stranger', descriptors, {
        **{one.name: 0.5 for one in descriptors[:400]}, 'odd': b'', 'many': [0.0] * 5000,
        'words': ['a', 'b']}))
    panel.search.setText('value399')
    assert [field.name for field in panel.fields() if field.isVisibleTo(panel)] == [
        'group0.value399']
    assert len(panel.fields()) == 403
    panel.deleteLater()
