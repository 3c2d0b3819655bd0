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
The study: what accuracy costs on this machine, measured, drawn and written down.

With --real, how near a flag is to real ones: sections/real, and of measures/ realism, published
and flapping.

    __main__   the command `study`                  tune           the command `tune`
    runner     shares the minutes, measures rows    search         its choice
                                                    candidates     what it tries
    store      rows that survive an interruption    settings_file  params files, read and written
    report     the report and its tables            machine        which one, and how busy it is
    plots      what all plots share
    measures/  what is measured: follows, behaves, rests, and a judge that asks all three
    sections/  the report's sections, one file each: what is run, its tables, its plots

Measures know nothing of what stands beside them. Knows nothing of ROS.
"""
