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

"""The scene of physics and renderer: which values stand together."""
from flag_sim.declarations.nodes import defaults
from flag_sim.declarations.scene import check_scene
import pytest


@pytest.mark.parametrize('changes, said', [
    ({'flag.width': 1e-5}, 'flag.width must be 0 or a number from 0.001 to 100 [m], not 1e-05'),
    ({'flag.length': 5e-4}, 'flag.length must be 0 or a number from 0.001 to 100 [m], not 0.0005'),
    ({'pole.diameter': 1.0}, 'platform.side must be greater than pole.diameter 1.0, not 1.0'),
    ({'pole.height': 0.5, 'pole.diameter': 0.5},
     'pole.diameter 0.5 m must be less than pole.height 0.5 m')])
@pytest.mark.parametrize('node', ['physics', 'renderer'])
def test_what_makes_no_scene_is_refused_by_the_parameters_names(node, changes, said):
    """Each of the values alone is a right one."""
    with pytest.raises(ValueError) as error:
        check_scene({**defaults(node), **changes})
    assert str(error.value) == said


@pytest.mark.parametrize('changes', [
    {}, {'flag.width': 1e-3, 'flag.length': 100.0}, {'pole.height': 0.1, 'pole.diameter': 0.05}])
def test_a_scene_is_accepted(changes):
    check_scene({**defaults('physics'), **changes})
