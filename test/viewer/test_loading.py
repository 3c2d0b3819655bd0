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

"""Params files that are loaded into nodes, and what the window says of them and takes back."""
from flag_sim.parameters.config import config_path
from flag_sim.ros.topics import publish
import pytest
from sensor_msgs.msg import Image
from support.window import Desk

TRACK = 'wind.speed'
TIMES = [0.0, 1.0, 2.0]


@pytest.fixture(scope='module')
def desk(module_domain):
    """Return a window on nodes, of which the renderer has a name of its own."""
    with Desk(module_domain, f'tracks:=[{TRACK}]', f'keys.{TRACK}.times:={TIMES}',
              f'keys.{TRACK}.values:={TIMES}', 'loop:=true', remaps=['renderer:__node:=left']
              ) as desk:
        desk.until(lambda: desk.window.counter.place is not None)
        yield desk


def said(desk):
    """Return what the window says below."""
    return desk.window.statusBar().currentMessage()


def load(desk, path, content):
    """Load a params file of some content."""
    path.write_text(content)
    desk.window.load(path)


def test_a_shot_is_loaded_whole(desk):
    """With its tracks in place of those before; how it is filmed stays, and it begins anew."""
    take = desk.window.counter.place.take
    desk.window.load(config_path('turn.yaml'))
    desk.until(lambda: desk.value('wind', 'tracks') == ['wind.azimuth']
               and desk.value('physics', 'preroll') == 4.0
               and desk.window.counter.place.take > take)
    assert (desk.value('wind', 'pace'), desk.value('wind', 'frames')) == ('realtime', 0)
    assert f'no longer played: {TRACK}' in said(desk)
    desk.window.load('there is none.yaml')
    assert 'was not loaded' in said(desk)
    desk.window.timeline.model.undo()  # of what the wind had
    desk.until(lambda: desk.value('wind', 'tracks') == [TRACK])
    assert desk.value('wind', f'keys.{TRACK}.times') == TIMES
    desk.until(lambda: not said(desk))  # it was of what is undone


def test_a_file_that_a_node_refuses_is_not_loaded_at_all(desk, tmp_path):
    """The renderer, whatever its name is, gets what is for a renderer."""
    before = [desk.value('wind', 'speed'), desk.value('physics', 'gravity'),
              desk.value('renderer', 'samples')]
    load(desk, tmp_path / 'bad.yaml', """
/**/wind: {ros__parameters: {speed: 4.0, frames: 9}}
/**/physics: {ros__parameters: {gravity: 1.5}}
/**/renderer: {ros__parameters: {samples: 4, width: -5}}
""")
    desk.until(lambda: 'not loaded: renderer: width must be' in said(desk))
    desk.until(lambda: before == [desk.value('wind', 'speed'), desk.value('physics', 'gravity'),
                                  desk.value('renderer', 'samples')])
    assert desk.value('wind', 'tracks') == [TRACK]


@pytest.mark.parametrize('content, words', [
    ('/**/wind: {ros__parameters: {sped: 5.0}}',
     'a.yaml has nothing for the nodes that are there; wind has no sped (speed?)'),
    ('/**/wind: {ros__parameters: {gust: {sed: 1}}}\n/**/fysics: {ros__parameters: {a: 1.0}}',
     'there; wind has no gust.sed (gust.seed?); no node here is /**/fysics'),
    ('/**/physics: {ros__parameters: {gravity: 9.81, gravty: 1.0}}',
     'a.yaml: set for physics: 1; physics has no gravty (gravity?)'),
    ('/**: {ros__parameters: {gravity: 9.81}}\n'
     '/**/wind: {ros__parameters: {qos_overrides: {a: 1}}}',
     'a.yaml: set for physics: 1'),
    ('/**/physics: {ros__parameters: {gravity: fast}}',
     "a.yaml was not loaded: physics: gravity: 'fast' is no float")])
def test_names_that_no_node_reads_are_told(desk, tmp_path, content, words):
    """Not those in a section for all nodes, of which some read them."""
    load(desk, tmp_path / 'a.yaml', content)
    desk.until(lambda: said(desk).endswith(words))


def test_what_was_said_goes_with_its_reason(desk):
    """A refusal with the next value that is taken, or with the node; also that of an image."""
    field = desk.window.panel.field('physics', 'gravity')
    desk.model.put('physics', {'gravity': 1e9})
    desk.until(lambda: 'gravity must be' in said(desk))
    assert 'gravity must be' in field.refusal
    desk.model.put('physics', {'gravity': 3.0})
    desk.until(lambda: not said(desk) and not field.refusal)
    desk.model.put('physics', {'gravity': 1e9})
    desk.until(lambda: field.refusal)
    desk.end('physics')
    desk.until(lambda: not desk.model.is_known('physics'))
    assert not field.refusal and not said(desk)
    view = desk.window.view
    broken = publish(desk.viewer, 'camera/image_raw')
    desk.until(lambda: broken.publish(Image(height=2, width=2, step=6, encoding='rgb8'))
               and 'cannot be read: an image of 2 rows' in view.reason)
    words = 'many\nlines' * 50
    desk.until(lambda: broken.publish(Image(
        height=1, width=1, step=1, encoding=words, data=b'1')) and 'encoding' in view.reason)
    assert len(view.reason) < 300 and '\n' not in view.reason


def test_buttons_of_the_wind_need_one(desk):
    buttons = [desk.window.panel._run, *desk.window.panel._of_wind]
    assert all(button.isEnabled() for button in buttons)
    desk.end('wind')
    desk.until(lambda: not any(button.isEnabled() for button in buttons))
