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
import itertools
import os

import pytest

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'

_domains = itertools.count(1)


@pytest.fixture(scope='session')
def new_domain():
    """Return a function that returns a ROS domain, another one at each of a hundred calls."""
    # Domains 1 to 100 stay below the ports that Linux hands out by itself.
    return lambda: 1 + (os.getpid() + next(_domains)) % 100


@pytest.fixture
def domain(new_domain):
    """Return a ROS domain that no other test of this run uses at the same time."""
    return new_domain()
