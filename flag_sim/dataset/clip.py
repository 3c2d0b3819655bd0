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

"""One clip: drawn from its recipe, filmed, and put into its folder with its row."""
from collections.abc import Iterator
import functools
import importlib.metadata
import itertools
import shutil
import threading
import time

from flag_sim.dataset.channels import arrays_of, picture_channels, scene_of, View
from flag_sim.dataset.npz import NpzWriter
from flag_sim.dataset.recipe import Drawn, Recipe, recipe_of
from flag_sim.dataset.shot import NoClip, Shot
from flag_sim.dataset.store import ENDINGS, Store
from flag_sim.drawing import Picture

UNSEEN = 'the camera does not see the flag in any frame'
_of_thread = threading.local()


@functools.cache
def versions() -> dict[str, str]:
    """Return {package: version} of what clips are made by."""
    found = {}
    for name in ('flag_sim', 'numpy', 'numba'):
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:  # run from a source tree
            found[name] = ''
    return found


@functools.lru_cache(maxsize=2)
def cached_recipe(text: str) -> Recipe:
    """Return the recipe of a text, read once in a process."""
    return recipe_of(text)


def _picture():
    """Return the thread's Picture, which keeps its buffers from clip to clip."""
    if not hasattr(_of_thread, 'picture'):
        _of_thread.picture = Picture(threads=1)
    return _of_thread.picture


def views(recipe: Recipe, drawn: Drawn) -> Iterator[View]:
    """Yield the frames of a clip; what is drawn is good until the next one. Raises NoClip."""
    needed = picture_channels(recipe.channels)
    before, moment = None, None
    for after in itertools.chain(Shot(
            drawn, recipe.frames, recipe.rate, 'pole_load' in recipe.channels), [None]):
        if moment is not None:
            frame = None if needed is None else _picture().draw_scene(
                scene_of(moment, before), moment.look.camera, moment.look.light,
                moment.look.style, needed, before and before.look.camera)
            yield View(moment, before, after, frame)
        before, moment = moment, after


class Tally:
    """What a clip's row says of its frames."""

    def __init__(self):
        self.frames = self.seen_frames = self.softened_frames = 0

    def add(self, view: View) -> None:
        """Count a frame."""
        self.frames += 1
        self.softened_frames += view.moment.is_softened
        self.seen_frames += view.frame is None or view.flag_pixels > 0


def make_clip(recipe: Recipe, number: int, store: Store) -> dict:
    """
    Make a clip and return its row, which is in the folder then; it says whether, and why not.

    Raises OSError where the folder cannot be written; nothing is left of the clip then.
    """
    drawn = recipe.draw(number)
    made = store.temporary(number)
    try:
        return _make(recipe, drawn, store, made, time.perf_counter())
    finally:
        shutil.rmtree(made.parent, ignore_errors=True)


def _make(recipe, drawn, store, made, begin):
    """Film a clip at the path `made`, put it into its place, and return its row."""
    number, ending, tally = drawn.number, ENDINGS[recipe.file_format], Tally()
    try:
        written = _film(recipe, drawn, made, tally)
        status, reason = 'whole', ''
    except NoClip as error:
        written, status, reason = {'bytes': 0, 'sha256': ''}, 'failed', str(error)
    is_whole = status == 'whole'
    file = str(store.path(number, ending).relative_to(store.folder)) if is_whole else ''
    row = {'number': number, 'split': drawn.split, 'status': status, 'reason': reason,
           'file': file, **written, **vars(tally), 'rate': recipe.rate, 'seed': recipe.seed,
           'recipe': recipe.digest, 'seconds': time.perf_counter() - begin,
           **{f'version.{name}': version for name, version in versions().items()},
           'parameters': parameters_of(drawn)}
    store.put(number, made if is_whole else None, ending, row)
    return row


def _film(recipe, drawn, made, tally):
    """Write the frames at the path `made`; return the size and the digest of what is there."""
    with _writer(recipe, drawn, made) as writer:
        for view in views(recipe, drawn):
            tally.add(view)
            writer.append(arrays_of(view, recipe.channels), view)
        if not tally.seen_frames:
            raise NoClip(UNSEEN)
        return writer.finish()


def _writer(recipe, drawn, made):
    if recipe.file_format == 'npz':
        return NpzWriter(made, recipe.frames)
    from flag_sim.dataset.bag import BagWriter  # which needs ROS
    return BagWriter(made, recipe, drawn)


def parameters_of(drawn: Drawn) -> dict[str, object]:
    """Return {node.parameter: value} of all that a clip depends on, keys as `wind.keys...`."""
    from flag_sim.dataset.targets import declarations, spread
    found = {}
    for name in declarations():
        for node, own in spread({name: None}).items():
            for parameter in own:
                found[f'{node}.{parameter}'] = drawn.values[node][parameter]
    return {**found, **{name: value for name, value in drawn.chosen.items()
                        if name.startswith('wind.keys.')}}
