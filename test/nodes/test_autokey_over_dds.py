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

"""Autokey with real nodes: what is set on them becomes keys, which are saved and play again."""
from flag_sim.ros.messages import to_stamp
from std_msgs.msg import Empty
from support.forked import Graph
from support.shot import SMALL
from support.watch import eventually, Watcher
import yaml


def learn(watcher, wind, saved):
    """Wait until the wind knows the values of physics: from then on it hears of each change."""
    assert watcher.put(wind, 'resend_after', 2.0).successful  # no key, but it saves the shot
    eventually(lambda: not any(lack in saved.read_text() for lack in (
        'no physics was found', '/physics did not answer')), watcher)


def test_autokey_makes_keys_that_play_again(tmp_path, domain):
    """What a user sets becomes a key and is saved; the saved file plays; playback makes none."""
    saved = tmp_path / 'shot.yaml'
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        done, keys = watcher.listen('frame_done'), watcher.listen('keyframe')
        sent = watcher.listen('parameters')
        graph.start('physics')
        graph.start('renderer', *SMALL)
        graph.start('wind', '-p', 'autokey:=true', '-p', f'save_to:={saved}')
        client, wind = watcher.parameters_of('physics'), watcher.parameters_of('wind')
        eventually(lambda: len(done) > 15, watcher)
        learn(watcher, wind, saved)
        before = to_stamp(done[-1].stamp) / 1e9
        # The same value again makes no other key; of what is set last the wind hears last.
        for name, value in (('gravity', 1.5), ('gravity', 1.5), ('damping', 0.2)):
            assert watcher.put(client, name, value).successful
        eventually(lambda: 'physics.damping' in saved.read_text(), watcher)
        assert watcher.put(wind, 'paused', True).successful
        content = yaml.safe_load(saved.read_text())['/**/wind']['ros__parameters']
        assert content['tracks'] == ['physics.gravity', 'physics.damping']
        assert content['keys.physics.gravity.values'] == [9.81, 1.5]
        # Until the key it is as it was seen: it does not glide there from the beginning.
        assert content['keys.physics.gravity.laws'] == ['step', 'linear']
        first, second = content['keys.physics.gravity.times']
        assert first == 0.0 and before <= second
        # Not in the future: no frame is sent any more.
        eventually(lambda: round(second * 1e9) <= to_stamp(sent[-1].stamp), watcher)
        assert graph.end('wind') == 0
        del keys[:]
        # Paused, as the key comes once, and perhaps before the new wind is heard.
        graph.start('wind', '--params-file', str(saved), '-p', 'paused:=true')
        assert watcher.put(watcher.parameters_of('wind'), 'paused', False).successful
        eventually(lambda: round(second * 1e9) in [to_stamp(key.stamp) for key in keys], watcher)


def test_autokey_replaces_what_is_set_at_the_same_time(tmp_path, domain):
    """While the shot stands still: one key, whatever is set in between; the same value, none."""
    saved = tmp_path / 'shot.yaml'
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        winds, step = watcher.listen('wind'), watcher.publisher('step')
        graph.start('physics')
        graph.start('wind', '-p', 'autokey:=true', '-p', 'paused:=true', '-p',
                    f'save_to:={saved}')
        physics, wind = watcher.parameters_of('physics'), watcher.parameters_of('wind', step)
        learn(watcher, wind, saved)

        def keyed(part):
            return list(watcher.get(wind, f'keys.physics.gravity.{part}') or ())
        for count in range(1, 8):
            step.publish(Empty())
            eventually(lambda: len(winds) == count, watcher)
        now = to_stamp(winds[-1].header.stamp) / 1e9
        assert watcher.put(physics, 'gravity', 9.81).successful  # as it is already
        for gravity in (1.5, 2.5, 2.5):
            assert watcher.put(physics, 'gravity', gravity).successful
            eventually(lambda: keyed('values') == [9.81, gravity], watcher)
        assert keyed('times') == [0.0, now]
        assert watcher.get(wind, 'tracks') == ['physics.gravity']
        # Played to its key, the track sets nothing and so makes no key of its own.
        assert watcher.put(wind, 'paused', False).successful
        eventually(lambda: to_stamp(winds[-1].header.stamp) / 1e9 > now + 0.5, watcher)
        assert (keyed('times'), keyed('values')) == ([0.0, now], [9.81, 2.5])
