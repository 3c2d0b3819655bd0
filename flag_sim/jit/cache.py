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
Where the machine code of kernels is kept from one start to the next, and when it is out of date.

numba's own cache compares only the file that holds the kernel; here any edit of a module that may
hold a kernel compiles all of them anew. The classes derived from are numba's, private to it.

What is kept is loaded as a pickle, which may run any command. It is therefore kept only where
nobody else can put a file: beside the package, which is trusted as much as the package itself;
where the user says, by NUMBA_CACHE_DIR; or in a folder of this user's own. Without one, kernels
are compiled at every start.
"""
from collections.abc import Callable, Iterator
import contextlib
import functools
import hashlib
import os
from pathlib import Path
import stat
import tempfile
import threading

from flag_sim.jit.compilers import PartLibrary
import numba
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache
from numba.core.compiler import compile_result

PACKAGE = Path(__file__).resolve().parents[1]
WITHOUT_KERNELS = ('animation', 'declarations', 'nodes', 'parameters', 'protocol', 'ros', 'study',
                   'tools')
"""The folders that hold no kernel: to change them compiles nothing anew."""


@functools.lru_cache
def fingerprint() -> str:
    """Return a hash of every module that can hold a kernel."""
    digest = hashlib.sha256()
    for path in sorted(PACKAGE.rglob('*.py')):
        if path.relative_to(PACKAGE).parts[0] not in WITHOUT_KERNELS:
            digest.update(path.read_bytes())
    return digest.hexdigest()


def make_private(folder: Path) -> None:
    """
    Make a folder into which nobody else can put a file; raise OSError where it is none.

    It is ours, of mode 0700 and no link. Nobody but we and root can put another one in its place:
    the folders that it is in are ours or root's, and closed to others or sticky, as /tmp is.
    """
    folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    with contextlib.suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    found = folder.lstat()
    if (not stat.S_ISDIR(found.st_mode) or found.st_uid != os.geteuid()
            or stat.S_IMODE(found.st_mode) != 0o700):
        raise PermissionError(f'{folder} is not a folder of this user alone')
    inner = folder.parent.resolve()
    for parent in (inner, *inner.parents):
        found = parent.stat()
        is_open = found.st_mode & 0o022 and not found.st_mode & stat.S_ISVTX
        if found.st_uid not in (0, os.geteuid()) or is_open:
            raise PermissionError(f'others can put another folder in the place of {folder}')


class _Locator:
    """
    Says where a kernel's machine code is kept and when it is out of date.

    numba's own locators compare only the file that holds the kernel, and would go on running the
    old code of another kernel that it calls. And they give up where neither the package nor the
    home can be written. The interface is numba's.

    is_trusted: of a folder that counts whoever has made it.
    """

    def __init__(self, function, folder, is_trusted):
        self._function = function
        self._folder = folder
        self._is_trusted = is_trusted

    def get_cache_path(self):
        return str(self._folder)

    def ensure_cache_path(self):
        if self._is_trusted:
            self._folder.mkdir(parents=True, exist_ok=True)
        else:
            make_private(self._folder)
        tempfile.TemporaryFile(dir=self._folder).close()  # raises OSError if it may not be written

    def get_source_stamp(self):
        return fingerprint()

    def get_disambiguator(self):
        return str(self._function.__code__.co_firstlineno)

    @classmethod
    def from_function(cls, function, path):
        """Return a locator with the first folder that can be written, or None."""
        path = Path(path).resolve()
        name = '-'.join(['flag_sim', 'kernels', *path.relative_to(PACKAGE).parent.parts])
        trusted = [path.parent / '__pycache__']
        if numba.config.CACHE_DIR:
            trusted.insert(0, Path(numba.config.CACHE_DIR) / name)
        own = []
        with contextlib.suppress(RuntimeError, OSError):  # no home; no temporary folder
            own.append(Path('~/.cache').expanduser() / name)
            own.append(Path(tempfile.gettempdir()) / f'{name}-{os.geteuid()}')
        for folder in (*trusted, *own):
            locator = cls(function, folder, folder in trusted)
            try:
                locator.ensure_cache_path()
            except OSError:
                continue
            return locator
        return None


class _CacheImpl(FunctionCache._impl_class):
    _locator_classes = [_Locator]


class _PartLocator(_Locator):
    """Keeps what callers copy of a kernel beside the kernel's machine code."""

    def get_disambiguator(self):
        return f'{super().get_disambiguator()}-part'


class _PartCacheImpl(_CacheImpl):
    _locator_classes = [_PartLocator]

    def rebuild(self, target_context, payload):
        """Return what was compiled, as numba's own does, but without an executable."""
        library, fndesc, environment, signature, objectmode, lifted, annotation, *loads = payload
        return compile_result(
            target_context=target_context, typing_context=target_context.typing_context,
            library=PartLibrary.kept(target_context.codegen(), library), environment=environment,
            entry_point=object(), fndesc=fndesc, type_annotation=annotation, signature=signature,
            objectmode=objectmode, lifted=lifted, reload_init=loads[0], referenced_envs=loads[1])


class _CacheFile(IndexDataCacheFile):
    """
    The files of a kernel: an index, and one of machine code for each combination of types.

    numba numbers the latter, and reads the index for the next number. Two processes that compile
    for different types at once, as two nodes of different precision do, may take the same number,
    and one then loads the other's code ever after. Here the types give the name, and the index
    comes last: an entry that another process overwrites is compiled once more, and that is all.
    """

    def save(self, key, data):
        """Keep machine code; key: the types that it is for, and the processor."""
        name = self._data_name(int(hashlib.sha256(repr(key).encode()).hexdigest()[:12], 16))
        self._save_data(name, data)
        self._save_index({**self._load_index(), key: name})


_missed = []  # kernels that no cache held: each was compiled by this process
_local = threading.local()


class NotKept(Exception):
    """A kernel that was only to be loaded is not kept."""


def compilations() -> int:
    """Return how many kernels this process has begun to compile; the others it only loaded."""
    return len(_missed)


@contextlib.contextmanager
def loading_alone() -> Iterator[None]:
    """Raise NotKept where, in the `with` block, this thread would have to compile a kernel."""
    _local.is_loading = True
    try:
        yield
    finally:
        _local.is_loading = False


def _miss(name):
    """Note a kernel that no cache held."""
    if getattr(_local, 'is_loading', False):
        raise NotKept(name)
    _missed.append(name)


class KernelCache(FunctionCache):
    """A kernel's machine code on the disk, for each combination of types it was called with."""

    _impl_class = _CacheImpl

    def __init__(self, function):
        super().__init__(function)
        self._cache_file = _CacheFile(self._cache_path, self._impl.filename_base, fingerprint())
        # numba does not read what another version kept. What other sources kept must not be read
        # either: it may name classes that are gone.
        self._cache_file._version += fingerprint()

    def load_overload(self, sig, target_context):
        found = super().load_overload(sig, target_context)
        if found is None:
            _miss(self._py_func.__qualname__)
        return found


class PartCache(KernelCache):
    """What other kernels copy of a kernel, on the disk."""

    _impl_class = _PartCacheImpl


class NoKernelCache(NullCache):
    """For a machine without a folder that can be trusted: every start compiles."""

    def __init__(self, function):
        self._name = function.__qualname__

    def load_overload(self, sig, target_context):
        del sig, target_context
        _miss(self._name)


def kernel_cache(kind: type[KernelCache], function: Callable) -> KernelCache | NoKernelCache:
    """Return a cache of that kind for a kernel, if anything can be kept safely anywhere."""
    try:
        return kind(function)
    except RuntimeError:  # of numba, without a locator
        return NoKernelCache(function)
