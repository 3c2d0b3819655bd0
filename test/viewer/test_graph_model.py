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

"""What the window knows of the nodes, without nodes."""
from flag_sim.parameters.descriptor import Descriptor
from flag_sim.viewer.exchange import Answered, Changed, Described, Found, FramePlace, Reported
from flag_sim.viewer.exchange import SetParameters
from flag_sim.viewer.frame_counter import FrameCounter
from flag_sim.viewer.graph_model import GraphModel
from flag_sim.viewer.reasons import why_still
from flag_sim.viewer.status_line import compute_words, frame_words
import pytest

ALL = {role: f'/{role}' for role in ('wind', 'physics', 'renderer')}


def known(**nodes):
    """Return (model, what it has asked) that knows nodes {role: {name: value}}."""
    asked = []
    model = GraphModel(asked.append)
    model.take(Found({role: f'/{role}' for role in nodes}))
    for role, values in nodes.items():
        model.take(Described(f'/{role}', tuple(Descriptor(name, 'float') for name in values),
                             values))
    return model, asked


def test_what_was_asked_counts_until_the_node_has_answered_and_told():
    """In whichever order its answer and the event come; a drag never falls back in between."""
    for events in (['answer', 'event'], ['event', 'answer']):
        model, asked = known(renderer={'azimuth': 1.0})
        model.put('renderer', {'azimuth': 2.0})
        (request,) = asked
        assert isinstance(request, SetParameters) and request.values == {'azimuth': 2.0}
        assert model.wanted('renderer', 'azimuth') == 2.0 and model.value(
            'renderer', 'azimuth') == 1.0
        for event in events:
            model.take(Answered(request.token, {'azimuth': ''}) if event == 'answer'
                       else Changed('/renderer', {'azimuth': 2.001}))
            assert model.wanted('renderer', 'azimuth') in (2.0, 2.001)
        assert model.value('renderer', 'azimuth') == 2.001  # as the node has it


def test_what_is_refused_is_told_with_the_value_before():
    model, asked = known(renderer={'azimuth': 1.0})
    told = []
    model.on_answer.append(lambda *answer: told.append(answer))
    model.put('renderer', {'azimuth': 99.0})
    model.take(Answered(asked[0].token, {'azimuth': 'too much'}))
    assert told == [('renderer', {'azimuth': 'too much'})]
    assert model.wanted('renderer', 'azimuth') == 1.0
    model.put('physics', {'gravity': 1.0})
    assert told[1] == ('physics', {'gravity': 'there is no physics'})
    model.put_together('physics', {'gravity': 1.0}, told.append)
    assert told[2] == 'there is no physics'


def test_a_node_that_is_gone_is_forgotten_and_what_it_had_at_first_is_not():
    model, _ = known(renderer={'azimuth': 1.0})
    model.take(Changed('/renderer', {'azimuth': 3.0}))
    model.take(Changed('/stranger', {'azimuth': 4.0}))
    model.take(Found({}))
    assert not model.is_known('renderer') and model.value('renderer', 'azimuth') is None
    model.take(Found({'renderer': '/renderer'}))
    model.take(Described('/renderer', (Descriptor('azimuth', 'float'),), {'azimuth': 3.0}))
    assert (model.value('renderer', 'azimuth'), model.first_value('renderer', 'azimuth')) == (
        3.0, 1.0)


@pytest.mark.parametrize('nodes, words', [
    ((), 'make view'), (('wind',), 'ros2 run flag_sim renderer'),
    (('wind', 'renderer'), 'ros2 run flag_sim physics'),
    (('renderer',), 'ros2 run flag_sim physics'),
    (('physics', 'renderer'), 'ros2 run flag_sim wind'),
    (('wind', 'physics', 'renderer'), 'No picture for 7 s, and no node says why.')])
def test_the_reason_names_what_is_lacking(nodes, words):
    model, _ = known(**{role: {} for role in nodes})
    assert words in why_still(model, 7.0)


def test_the_reason_is_what_the_nodes_say():
    model, _ = known(wind={'paused': False}, physics={}, renderer={})
    assert why_still(model, 0.0) == 'Waiting for the first picture.'
    model.take(Reported('/physics', False, 'the cloth has diverged', {}))
    assert why_still(model, 3.0) == '/physics: the cloth has diverged'
    model.take(Changed('/wind', {'paused': True}))
    assert 'paused' in why_still(model, 3.0)
    bare = GraphModel(lambda _: None)
    bare.take(Found(ALL))
    assert why_still(bare, 3.0) == '/wind is there, and has not answered yet.'


def test_the_figures_of_frames():
    """Frames without a picture are counted within a take, from the first that was seen."""
    counter = FrameCounter()
    for n, index in enumerate((10, 11, 13, 14, 20)):
        counter.show(index * 10**9, FramePlace(index * 10**9, 1, index), 100.0 + n)
    assert counter.skipped == 6 and counter.shown == 5
    assert counter.rate(104.0) == pytest.approx(1.0)
    words = frame_words(counter, 104.0)
    assert 'frame 20' in words and 'stamp 20.000 s' in words and '6 frames not shown' in words
    counter.show(0, FramePlace(0, 2, 0), 105.0)
    assert counter.skipped == 0
    counter.show(10**9, None, 106.0)  # the wind has not announced it
    assert counter.place.index == 0 and counter.still(110.0) == 4.0
    assert counter.rate(200.0) == 0.0


def test_the_times_of_the_nodes_are_theirs():
    model, _ = known(wind={}, physics={}, renderer={})
    for node, time in (('/wind', '0.25'), ('/physics', 'no frame')):
        model.take(Reported(node, True, '', {'compute time per frame [ms]': time}))
    assert compute_words(model) == 'wind 0.25 ms \u00b7 physics no frame'
