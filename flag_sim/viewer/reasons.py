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

"""Why no new picture comes, in words for people."""
from flag_sim.viewer.graph_model import GraphModel, ROLES

TOPICS = {'wind': 'parameters', 'physics': 'vertices', 'renderer': 'camera/image_raw'}
NOBODY = ('No node is there yet. Start them, each in a terminal of its own:\n'
          'ros2 run flag_sim physics\nros2 run flag_sim renderer\nros2 run flag_sim wind\n'
          'or all at once with this window, from the sources: make view')


def why_still(model: GraphModel, seconds: float) -> str:
    """
    Return why there has been no new picture for so many seconds, as far as the nodes tell.

    What comes first in the flow of data is told first: without a wind there are no vertices.
    """
    if not model.nodes:
        return NOBODY
    lacking = [role for role in ROLES if role not in model.nodes]
    # A bag of vertices is drawn without a wind.
    if 'renderer' in lacking or lacking == ['physics'] or lacking == ['wind', 'physics']:
        role = lacking[-1] if 'renderer' in lacking else 'physics'
        return (f'Nobody publishes {TOPICS[role]}. A first start compiles for some seconds.\n'
                f'To start the node that does: ros2 run flag_sim {role}')
    if model.value('wind', 'paused') is True:
        return ('The wind is paused. Run, or step to the next frame;\n'
                'what is changed meanwhile is seen then.')
    if 'wind' in lacking:
        return ('Nobody publishes parameters. To start the node that does: '
                'ros2 run flag_sim wind')
    for role in ROLES:
        report = model.report(role)
        if report is not None and not report.is_ok:
            return f'{report.node}: {report.message}'
    if not model.is_known('wind'):
        return f'{model.nodes["wind"]} is there, and has not answered yet.'
    return f'No picture for {seconds:.0f} s, and no node says why.' if seconds else (
        'Waiting for the first picture.')
