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

"""How a node tells whoever started it that it is ready, how far it is, and that it ends."""
import signal
import socket

from flag_sim.protocol.notify import NotifyReceiver, NotifySender
from flag_sim.tools.graph import Graph, NotReady
import pytest
from support.watch import eventually, Watcher


@pytest.fixture
def receiver(monkeypatch):
    """Return the receiving end of what this process sends."""
    end = NotifyReceiver()
    monkeypatch.setenv('NOTIFY_SOCKET', end.address)
    yield end
    end.close()


def test_what_was_told_is_heard(receiver):
    """The latest of every variable, whenever it is asked for."""
    sender = NotifySender()
    assert sender.is_connected and receiver.variables() == {}
    sender.send(READY=1)
    sender.send(STATUS='3 frames = 0.1 s', X_FLAG_SIM_FRAMES=3)
    expected = {'READY': '1', 'STATUS': '3 frames = 0.1 s', 'X_FLAG_SIM_FRAMES': '3'}
    assert receiver.variables() == expected == receiver.variables()


def test_a_receiver_that_sleeps_hears_the_last_word(receiver):
    """However much was told meanwhile; news is left out rather than what must arrive."""
    sender = NotifySender()
    sender.send(READY=1)
    assert not any(sender.send_progress(X_FLAG_SIM_FRAMES=n) for n in range(100))
    sender.send(STOPPING=1, X_FLAG_SIM_FRAMES=100)
    # What finds no room is waited for and then lost: this found it.
    assert receiver.variables() == {'READY': '1', 'STOPPING': '1', 'X_FLAG_SIM_FRAMES': '100'}
    assert sender.send_progress(X_FLAG_SIM_FRAMES=101)


def test_a_socket_that_is_a_file_is_told_too(tmp_path, monkeypatch):
    """As systemd's own is."""
    monkeypatch.setenv('NOTIFY_SOCKET', str(tmp_path / 'notify'))
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as receiver:
        receiver.bind(str(tmp_path / 'notify'))
        NotifySender().send(READY=1)
        assert receiver.recv(100) == b'READY=1\n'


def test_nobody_who_listens_hinders_nobody(receiver, monkeypatch):
    """No socket, one that is nowhere, or one that is gone."""
    sender = NotifySender()
    receiver.close()
    sender.send(READY=1)
    assert not NotifySender().is_connected
    monkeypatch.delenv('NOTIFY_SOCKET')
    sender = NotifySender()
    sender.send(READY=1)
    assert not sender.is_connected and not sender.send_progress(STATUS='')


def test_nodes_tell_of_their_lives(tmp_path, domain):
    """Ready, then how many frames, then the end with the figures."""
    with Graph(tmp_path / 'log', domain) as graph, Watcher(domain) as watcher:
        graph.start('wind', '-p', 'wait_for:=[]')
        assert 'STOPPING' not in graph.told('wind')
        graph.wait_ready('wind')
        eventually(lambda: int(graph.told('wind').get('X_FLAG_SIM_FRAMES', 0)) > 3, watcher)
        assert graph.told('wind')['STATUS'].endswith(' frames')
        assert graph.end('wind') == 0
        told = graph.told('wind')
        assert told['STOPPING'] == '1'
        shares = [float(told[f'X_FLAG_SIM_{name}']) for name in ('WAIT', 'WORK', 'PUBLISH')]
        assert sum(shares) == pytest.approx(100.0) and float(told['X_FLAG_SIM_SECONDS']) > 0.0


def test_a_node_that_does_not_start_is_not_waited_for(tmp_path, domain):
    """The reason is in what is raised."""
    with Graph(tmp_path / 'log', domain) as graph:
        graph.start('wind', '-p', 'speed:=-1.0')
        with pytest.raises(NotReady, match='wind is not ready; it said:\nrefused: speed must be'):
            graph.wait_ready('wind')
        graph.start('wind', name='killed').send_signal(signal.SIGKILL)
        with pytest.raises(NotReady, match='killed is not ready'):
            graph.wait_ready('killed')
