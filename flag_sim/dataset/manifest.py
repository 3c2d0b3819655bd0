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

"""The manifest: a table of all clips, with what each was made by; a file of Parquet."""
from collections.abc import Iterable, Iterator
import itertools
import json
from pathlib import Path
import re

from flag_sim.dataset.store import Store
from flag_sim.dataset.targets import declarations, spread

NO_PYARROW = "a manifest needs pyarrow: pip install 'flag_sim[dataset]'"
ROWS_A_GROUP = 1000
COLUMNS = {'number': 'int64', 'split': 'string', 'status': 'string', 'reason': 'string',
           'file': 'string', 'bytes': 'int64', 'sha256': 'string', 'content': 'string',
           'frames': 'int64', 'seen_frames': 'int64', 'softened_frames': 'int64',
           'rate': 'float64', 'seed': 'uint64',
           'recipe': 'string', 'seconds': 'float64', 'version.flag_sim': 'string',
           'version.numpy': 'string', 'version.numba': 'string'}
"""What the manifest says of a clip beside its parameters, and the types in Arrow."""
KEYS = 'wind.keys'
"""The column of the keys of tracks, {parameter of the wind: value} as JSON."""
READ = ('number', 'split', 'status', 'reason', 'file')
"""The columns without which clips cannot be read."""
LONGEST = 200
"""Letters of another's message that are shown."""
TYPES = {bool: 'bool_', int: 'int64', float: 'float64', str: 'string'}


def _schema(pyarrow):
    fields = [(name, getattr(pyarrow, kind)()) for name, kind in COLUMNS.items()]
    for name, declaration in declarations().items():
        kind = getattr(pyarrow, TYPES[declaration.kind])()
        for node, own in spread({name: None}).items():
            fields += [(f'{node}.{parameter}',
                        pyarrow.list_(kind) if declaration.is_list else kind)
                       for parameter in own]
    return pyarrow.schema([*fields, (KEYS, pyarrow.string())])


def as_columns(row: dict) -> dict[str, object]:
    """Return a row of the manifest, {column: value}, of a clip's row."""
    parameters = row['parameters']
    keys = {name.removeprefix('wind.'): value for name, value in parameters.items()
            if name.startswith(f'{KEYS}.')}
    return {**{name: row.get(name) for name in COLUMNS}, KEYS: json.dumps(keys),
            **{name: value for name, value in parameters.items()
               if not name.startswith(f'{KEYS}.')}}


def write(path: Path, rows: Iterable[dict]) -> int:
    """Write the rows of clips as a manifest, whole or not at all; return how many there are."""
    import pyarrow
    import pyarrow.parquet
    schema, count = _schema(pyarrow), 0
    beside = path.with_name(f'.new-{path.name}')
    try:
        with pyarrow.parquet.ParquetWriter(beside, schema) as writer:
            for group in _groups(rows):
                writer.write_table(pyarrow.Table.from_pylist(
                    [as_columns(row) for row in group], schema=schema))
                count += len(group)
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)
    return count


def _groups(rows):
    group = []
    for row in rows:
        group.append(row)
        if len(group) == ROWS_A_GROUP:
            yield group
            group = []
    if group:
        yield group


def rows_of(store: Store, numbers: range) -> Iterator[dict]:
    """Yield the rows of the clips that are there, in the order of their numbers."""
    return filter(None, map(store.row, store.listed(numbers)))


def all_rows(store: Store, numbers: range) -> Iterator[dict]:
    """Yield such rows, and then those of clips beyond, which a run that asked for more made."""
    return itertools.chain(rows_of(store, numbers), filter(
        None, map(store.row, store.beyond(numbers))))


def read(folder: Path) -> object:
    """
    Return the manifest of a dataset, those of its shards together: a pyarrow.Table by number.

    A clip that two of them list, and only one as whole, is whole. Raises FileNotFoundError where
    there is none, ValueError for one that cannot be read, and ImportError without pyarrow.
    """
    try:
        import pyarrow
    except ImportError:
        raise ImportError(NO_PYARROW) from None
    paths = paths_in(folder)
    if not paths:
        raise FileNotFoundError(f'{folder} has no manifest: no run has come to its end there')
    tables = list(map(read_one, paths))
    for path, table in zip(paths, tables):
        if table.schema != tables[0].schema:
            raise ValueError(f'{path} has other columns than {paths[0]}: one of them is of '
                             f'another dataset; {_again(path)}')
    table = pyarrow.concat_tables(tables).sort_by(
        [('number', 'ascending'), ('status', 'descending')])  # whole before failed
    numbers = table.column('number').to_numpy()
    first = [True, *(numbers[1:] != numbers[:-1])] if len(numbers) else []
    return table.filter(pyarrow.array(first, pyarrow.bool_()))


def paths_in(folder: Path) -> list[Path]:
    """Return where the manifests of a dataset are."""
    return sorted(Path(folder).glob('manifest*.parquet'))


def read_one(path: Path) -> object:
    """Return one manifest, a pyarrow.Table; raise ValueError for what is none."""
    import pyarrow
    import pyarrow.parquet
    try:
        table = pyarrow.parquet.read_table(path)
    except (pyarrow.ArrowException, OSError) as error:
        raise ValueError(f'{path} cannot be read: {" ".join(str(error).split())[:LONGEST]}; '
                         f'{_again(path)}') from None
    lacking = [name for name in READ if name not in table.column_names]
    if lacking:
        raise ValueError(f'{path} has no column {lacking[0]}: it is no manifest of clips; '
                         f'{_again(path)}')
    return table


def _again(path):
    """Return in words how to come by a right manifest."""
    shard = re.fullmatch(r'manifest-(\d+)-of-(\d+)\.parquet', path.name)
    if not shard and path.name != 'manifest.parquet':
        return 'remove it: no run has written it'
    option = ' with --shard {}/{}'.format(*map(int, shard.groups())) if shard else ''
    return f'remove it, and the command that made the clips{option} writes it again'
