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

"""What the references themselves are wrong by: what is less than some times that is no rank."""
from flag_sim.study.measures import ranking, summary
from flag_sim.study.store import Store

ROWS = 'references'  # name of the rows
HALF, QUARTER = 'a grid half as fine', 'a grid a quarter as fine, from half'


def own_px(store: Store, column: str) -> float | None:
    """Return the own error of the reference of forecasts in a column [px]; None: not known."""
    rows = summary.grouped(store.rows(ROWS), 'what')
    if not {HALF, QUARTER} <= set(rows):
        return None
    return ranking.own_error(*(summary.total(rows[what], column) for what in (QUARTER, HALF)))


def least_px(store: Store, column: str) -> float:
    """Return by how much errors must differ to be ranked [px]; 0 where it is not known."""
    return ranking.FROM * (own_px(store, column) or 0.0)
