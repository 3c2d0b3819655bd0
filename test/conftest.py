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

"""Fixtures that several test modules share."""
import os
import types

from flag_sim.tools.domains import claimed_domain
from hypothesis import HealthCheck, settings
import pytest
from support.compiled import compile_kernels
from support.soak import SOAK

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
os.environ['QT_QPA_PLATFORM'] = 'offscreen'  # windows are drawn, and seen by nobody
# No test fails because a machine is slow, nor by examples that the last run did not try.
settings.register_profile('flag_sim', deadline=None, derandomize=not SOAK, database=None,
                          suppress_health_check=[HealthCheck.too_slow])
settings.load_profile('flag_sim')


def pytest_configure(config):
    """Compile kernels once, where several workers are about to begin (`-n`)."""
    if getattr(config.option, 'numprocesses', None) and not hasattr(config, 'workerinput'):
        compile_kernels()


@pytest.fixture
def domain():
    """Return a ROS domain that nobody else on this host uses at the same time."""
    with claimed_domain() as number:
        yield number


@pytest.fixture(scope='module')
def module_domain():
    """Return a domain for all tests of a module."""
    with claimed_domain() as number:
        yield number


@pytest.fixture
def still_log(monkeypatch):
    """Let no time pass for the logs of nodes here: what is told once is not told again."""
    monkeypatch.setattr('flag_sim.ros.node_log.time', types.SimpleNamespace(
        monotonic=lambda: 1000.0))
