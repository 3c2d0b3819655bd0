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

"""
Fixtures for the tests of others: a flag is filmed, and its frames are compared with stored ones.

In a conftest.py: `pytest_plugins = ['flag_sim.testing']`.
"""
from collections.abc import Callable
from pathlib import Path

from flag_sim.testing.film import Filmed, play
from flag_sim.testing.golden import Golden
import pytest

__all__ = ['film', 'Filmed', 'Golden', 'golden', 'pytest_addoption']


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option by which golden frames are stored anew."""
    parser.getgroup('flag_sim').addoption(
        '--golden-update', action='store_true',
        help='store the frames that tests see as the golden ones, instead of comparing')


@pytest.fixture
def film(tmp_path: Path) -> Callable[..., Filmed]:
    """
    Return what plays a shot in real nodes and hands over its frames.

    To be called with (frames, topics, shot, node={parameter: value}, ...), see
    flag_sim.testing.film.play. The nodes are processes in a ROS domain of their own, in lockstep,
    and have ended when it returns.
    """
    return lambda *args, **nodes: play(tmp_path / 'film', *args, **nodes)


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> Golden:
    """
    Return what fails unless an image is the stored one; to be called with (name, rgb).

    The folder `golden` beside the test's file holds them; see flag_sim.testing.golden.Golden.
    """
    return Golden(request.path.parent / 'golden', request.config.getoption('golden_update'))
