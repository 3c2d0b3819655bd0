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

"""Signatures: few arguments, for what belongs together is one record; type hints; short files."""
import ast
import inspect
from pathlib import Path

import flag_sim
import flag_sim.cloth
import flag_sim.drawing

import pytest

PACKAGE = Path(flag_sim.__file__).parent
MODULES = sorted(PACKAGE.rglob('*.py'))
MOST = 8

EXCEPTIONS = {
    'cloth/simulation.py: Cloth.__init__':
        'what users make a flag with: all have defaults, and most can only be given by name'}
"""Functions of more arguments, and why."""


def functions(tree, prefix=''):
    """Return (name, node) of all functions of a tree, with the classes and functions around."""
    found = []
    for node in ast.iter_child_nodes(tree):
        name = prefix + (getattr(node, 'name', None) or '')
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            found.append((name, node))
        inside = isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef))
        found += functions(node, f'{name}.' if inside else prefix)
    return found


def long_lists(path):
    """Return {file: function} of the functions of a file with more than MOST arguments."""
    found = {}
    for name, node in functions(ast.parse(path.read_text())):
        arguments = [one.arg for one in (*node.args.posonlyargs, *node.args.args,
                                         *node.args.kwonlyargs) if one.arg not in ('self', 'cls')]
        if len(arguments) > MOST:
            found[f'{path.relative_to(PACKAGE)}: {name}'] = len(arguments)
    return found


@pytest.mark.parametrize('path', MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_function_takes_more_than_eight(path):
    """Kernels included: a record of arrays costs nothing (see cloth.records)."""
    assert set(long_lists(path)) <= set(EXCEPTIONS)


def test_every_exception_is_one():
    assert set().union(*map(long_lists, MODULES)) == set(EXCEPTIONS)


@pytest.mark.parametrize('path', [path for path in MODULES
                                  if path.relative_to(PACKAGE).parts[0] in ('cloth', 'drawing')],
                         ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_file_is_long(path):
    assert len(path.read_text().splitlines()) <= 300


@pytest.mark.parametrize('package, name', [(package, name) for package in (
    flag_sim.cloth, flag_sim.drawing) for name in package.__all__],
    ids=lambda one: one if isinstance(one, str) else '')
def test_public_functions_have_type_hints_and_docstrings(package, name):
    public = getattr(package, name)
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


@pytest.mark.parametrize('path', sorted((PACKAGE / 'cloth').rglob('*.py')),
                         ids=lambda path: str(path.relative_to(PACKAGE)))
def test_functions_of_the_cloth_have_type_hints(path):
    """Those that other modules may call, kernels too."""
    tree = ast.parse(path.read_text())
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    for owner in (tree, *classes):
        for node in owner.body:
            if isinstance(node, ast.FunctionDef) and not node.name.startswith('_'):
                arguments = [one for one in (*node.args.args, *node.args.kwonlyargs)
                             if one.arg not in ('self', 'cls')]
                assert node.returns is not None, node.name
                assert all(one.annotation is not None for one in arguments), node.name
