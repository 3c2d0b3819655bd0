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

"""The pages of the docs, and the code and commands that stand in them."""
from pathlib import Path
import re

ROOT = Path(__file__).resolve().parents[2]
PAGES = ['README.md', 'CONTRIBUTING.md',
         *(f'docs/{path.name}' for path in sorted(ROOT.glob('docs/*.md')))]
COMMAND = r'(?:ros2|make|pip|wind|export|\.venv/bin/python)'


def text_of(page):
    """Return a page's text."""
    return (ROOT / page).read_text()


def blocks(page, language):
    """Return the texts of a page's fenced blocks of a language."""
    return re.findall(rf'^```{language}\n(.*?)^```', text_of(page), re.DOTALL | re.MULTILINE)


def commands(page):
    """Return a page's commands, without comments: those of its blocks, then those in its text."""
    lines = ''.join(blocks(page, 'bash')).replace('\\\n', ' ').splitlines()
    text = re.sub(r'^```.*?^```', '', text_of(page), flags=re.DOTALL | re.MULTILINE)
    inline = [' '.join(code.split()) for code in re.findall(r'`([^`]+)`', text)]
    found = [re.sub(r'\s+#.*', '', ' '.join(line.split())) for line in lines if line.strip()]
    return [*found, *(code for code in inline if re.match(COMMAND + ' ', code))]
