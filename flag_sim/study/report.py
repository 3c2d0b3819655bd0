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

"""The report: all sections from top to bottom, with the machine named; and its tables."""
import datetime
from pathlib import Path

from flag_sim.study import machine, plots
from flag_sim.study.runner import load_of_others
from flag_sim.study.store import Store


TITLE = """# What accuracy costs

How near a flag can be had to the exact one, and for how much processor time."""


def table(head: list[str], rows: list[list]) -> str:
    """
    Return a Markdown table; columns of numbers are aligned to the right, but for the first.

    head: names of the columns, with their units; rows: of numbers, shown to 3 significant digits,
    and texts.
    """
    right = [any(isinstance(value, (int, float)) for value in column) for column in zip(*rows)]
    lines = [head, [':--', *('--:' if is_right else ':--' for is_right in right[1:])]]
    lines += [[number(value) for value in row] for row in rows]
    return '\n'.join('| ' + ' | '.join(line) + ' |' for line in lines)


def number(value: float | str | None) -> str:
    """Return a number to three significant digits as text; text as it is; None as a dash."""
    if value is None:
        return '–'
    if not isinstance(value, float):
        return str(value)
    if value != 0.0 and not 1e-3 <= abs(value) < 1e5:
        return f'{value:.2e}'
    return f'{value:.3g}' if abs(value) < 1000.0 else f'{value:.0f}'


def write(store: Store, sections: list, minutes: float, title: str = TITLE) -> Path:
    """Write report.md, on modules of sections, into the store's folder; return its path."""
    texts, missing = [title], []
    for section in sections:
        text = section.text(store).strip()
        if not text:
            missing.append(section.NAME)
            continue
        texts.append(text)
        if plots.can_draw() and hasattr(section, 'plots'):
            texts += [f'![{file.removesuffix(".png")}]({file})\n\n*{what_to_see}*'
                      for file, what_to_see in section.plots(store)]
        if store.rows(section.NAME):
            texts.append(f'All numbers: [{section.NAME}.csv]({section.NAME}.csv)')
    if missing:
        texts.append(f'Not measured, as there was not enough time: {", ".join(missing)}. The same '
                     'command goes on from here.')
    path = store.folder / 'report.md'
    path.write_text('\n\n'.join([*texts, *_foot(minutes, load_of_others(store))]) + '\n')
    return path


def _foot(minutes, others):
    """Return where it was measured, and how far its times can be trusted."""
    texts = ['## Where it was measured', table(['', ''], [
        ['date', datetime.datetime.now().astimezone().strftime('%Y-%m-%d %H:%M %Z')],
        ['machine', f'{machine.processor()}, {machine.cores()} cores'],
        ['with', machine.versions()], ['time given', f'{minutes:g} min'],
        ['processors kept busy by others', None if others is None else f'{others:.2f}']])]
    if machine.is_busy(others):
        texts.append(f'**This machine was busy with something else (it took {others:.2f} '
                     'processors on average).** Times are those of the processor, which others '
                     'lengthen only by sharing its caches; compare them with one another.')
    return texts if plots.can_draw() else [*texts, plots.MISSING]
