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
The machinery of parameters: how one is declared, checked, and written to a params file.

- declaration: one parameter: name, default, unit, range, choices, effect
- declared: declarations beside the fields of dataclasses, and groups of them for nodes
- checks: refusal of other bad values
- closed: refusal of unknown attributes
- arguments: types of command-line arguments
- params_file, file_targets: writing a params file; which nodes one has parameters for
- config: where the package's own params files are
"""
