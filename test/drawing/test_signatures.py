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

"""Signatures in drawing: few arguments, for what belongs together is one record; type hints."""
import ast
import inspect
from pathlib import Path

import flag_sim.drawing

import pytest

MODULES = sorted(Path(flag_sim.drawing.__file__).parent.glob('*.py'))


@pytest.mark.parametrize('path', MODULES, ids=lambda path: path.stem)
def test_no_function_has_more_than_eight(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.FunctionDef):
            names = [one.arg for one in (*node.args.posonlyargs, *node.args.args,
                                         *node.args.kwonlyargs) if one.arg != 'self']
            assert len(names) <= 8, f'{node.name} takes {len(names)}'


@pytest.mark.parametrize('path', MODULES, ids=lambda path: path.stem)
def test_no_file_is_long(path):
    assert len(path.read_text().splitlines()) <= 300


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
