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

"""What drawing offers has type hints and docstrings."""
import inspect

import flag_sim.drawing

import pytest


@pytest.mark.parametrize('name', flag_sim.drawing.__all__)
def test_public_functions_have_type_hints_and_docstrings(name):
    public = getattr(flag_sim.drawing, name)
    functions = [public] if inspect.isfunction(public) else [
        function for method, function in inspect.getmembers(public, inspect.isfunction)
        if not method.startswith('_')]
    assert public.__doc__
    for function in functions:
        hints = inspect.signature(function)
        assert function.__doc__, function
        assert hints.return_annotation is not hints.empty, function
        for argument in hints.parameters.values():
            assert argument.name == 'self' or argument.annotation is not hints.empty, function
