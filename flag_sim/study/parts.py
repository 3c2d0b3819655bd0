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
The parts of a study, in the order of the report.

A part is a module with

    NAME                          of its rows' file, NAME.csv
    SHARE                         of the study's time, in parts of the sum of all shares
    run(store, budget)            measures: adds rows to store's NAME while the budget allows
    plots(rows, folder)           draws into folder: [(file name, what to see there)]
    section(rows)                 its Markdown text in the report, heading (##) first

run goes on where it was interrupted (Store.has), and every number that it adds but times is the
same in every run. plots is only called where matplotlib is installed.
"""
from flag_sim.study import (
    ablation, convergence, dials, frontier, horizon, limits, longrun, methods, stability)

PARTS = [convergence, methods, horizon, longrun, dials, frontier, stability, limits, ablation]
