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

"""Types of what commands take, for argparse."""
import argparse
import math
from pathlib import Path

from flag_sim.parameters import checks


def positive(text: str) -> float:
    """Return an argument as a number; raises ArgumentTypeError unless it is above zero."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0.0 < number < math.inf:
        raise argparse.ArgumentTypeError(f'must be a number above 0, not {text}')
    return number


def given_path(text: str) -> Path:
    """
    Return an argument as a Path, `~` read as a shell does.

    Raises ArgumentTypeError, also for an empty one, which Path takes for the working folder.
    """
    if not text or '\0' in text:
        raise argparse.ArgumentTypeError('a path must be named')
    try:
        return checks.path('path', text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(error) from None
