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

"""The layouts for other programs show topics that there are, as what they are."""
import ast
import json

from flag_sim.parameters.config import config_path
from flag_sim.ros import messages
from flag_sim.ros.topics import TOPICS
import pytest
import yaml

RVIZ = {'Marker': 'Marker', 'PointCloud2': 'PointCloud2', 'Pose': 'PoseStamped', 'Image': 'Image'}
"""The type of message that a display of RViz takes."""
FOXGLOVE = {'/marker': 'Marker', '/vertices': 'PointCloud2', '/camera/pose': 'PoseStamped',
            '/camera/camera_info': 'CameraInfo'}
"""Types that Foxglove's 3D panel draws, by the topics that it shows here."""


def kind_of(topic):
    """Return the name of the type of a topic, in the namespace of the files."""
    assert topic.startswith('/')
    return TOPICS[topic[1:]].message.__name__


def test_rviz_shows_topics_as_what_they_are():
    """Reliably, as they are sent, and in the frame that their headers name."""
    manager = yaml.safe_load(config_path('flag_sim.rviz').read_text())['Visualization Manager']
    shown = {}
    for display in manager['Displays']:
        name = display['Class'].removeprefix('rviz_default_plugins/')
        if 'Topic' in display:
            topic = display['Topic']
            assert topic['Reliability Policy'] == 'Reliable'
            assert kind_of(topic['Value']) == RVIZ[name]
            shown[topic['Value']] = name
    assert {'/marker', '/vertices', '/camera/image_raw'} <= set(shown)
    assert manager['Global Options']['Fixed Frame'] == messages.WORLD


def test_foxglove_shows_topics_as_what_they_are():
    """Every panel is in the layout once, and shows fields that the messages have."""
    layout = json.loads(config_path('flag_sim.foxglove.json').read_text())
    panels = layout['configById']
    picture = panels['Image!picture']['imageMode']
    assert kind_of(picture['imageTopic']) == 'Image'
    assert kind_of(picture['calibrationTopic']) == 'CameraInfo'
    assert {topic: kind_of(topic) for topic in panels['3D!flag']['topics']} == FOXGLOVE
    assert panels['3D!flag']['followTf'] == messages.WORLD
    assert kind_of(panels['DiagnosticSummary!state']['topicToRender']) == 'DiagnosticArray'
    for path in panels['Plot!wind']['paths']:
        topic, *fields = path['value'].split('.')
        value = TOPICS[topic[1:]].message()
        for field in fields:
            value = getattr(value, field)
        assert isinstance(value, float)

    def leaves(node):
        return [node] if isinstance(node, str) else [
            *leaves(node['first']), *leaves(node['second'])]
    assert sorted(leaves(layout['layout'])) == sorted(panels)


def test_rqt_shows_the_picture():
    """Every plugin that runs is named, and has settings only if it runs."""
    manager = json.loads(config_path('flag_sim.perspective').read_text())[
        'groups']['pluginmanager']
    plugins = ast.literal_eval(manager['keys']['running-plugins']['repr'])
    names = {f'plugin__{name.replace("/", "__")}__{number}'
             for name, numbers in plugins.items() for number in numbers}
    assert set(manager['groups']) <= names and len(names) == 3
    settings = manager['groups']['plugin__rqt_image_view__ImageView__1']['groups']['plugin']
    assert kind_of(ast.literal_eval(settings['keys']['topic']['repr'])) == 'Image'


@pytest.mark.parametrize('name', ['flag_sim.rviz', 'flag_sim.foxglove.json',
                                  'flag_sim.perspective'])
def test_every_topic_in_the_files_is_looked_at(name):
    """A text that begins with / is a topic of the package, or one of its fields."""
    topics = {f'/{topic.lstrip("/")}' for topic in TOPICS}

    def texts(node):
        if isinstance(node, dict):
            return [*map(str, node), *(text for one in node.values() for text in texts(one))]
        if isinstance(node, list):
            return [text for one in node for text in texts(one)]
        return [node] if isinstance(node, str) else []
    found = [text.strip("'") for text in texts(yaml.safe_load(config_path(name).read_text()))]
    named = {text.partition('.')[0] for text in found if text.startswith('/')}
    assert named and named <= topics
