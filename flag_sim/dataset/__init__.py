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
Datasets: thousands of clips, drawn from a recipe and filmed without the nodes, on many processors.

In a few lines, of what `ros2 run flag_sim dataset recipe.yaml --output flags` has made:

>>> from flag_sim.dataset import Clips
>>> clips = Clips('flags', split='train')
>>> clips[0]['vertices'], clips[0].parameters['wind.speed']

The modules, in the order in which a clip passes them:

- recipe: what clips have in common and what is drawn; it reads with the next six
- marked_yaml: YAML whose values know their lines
- targets: which parameters a recipe may set
- laws, drawn_tracks, splits: how values, keys and splits are drawn
- draws: the random numbers of a clip
- shot: the frames of a clip, as the nodes make them
- channels: what a clip holds of each frame
- clip: one clip, from its recipe to its file
- npz, bag: the files
- store: the folder, whole clips alone
- manifest: the table of all clips
- engine: the processes that make clips
- reader: Clips
- meshgraphnets, tfrecord: a conversion for users of MeshGraphNets
"""
from flag_sim.dataset.reader import Clip, Clips

__all__ = ['Clip', 'Clips']
