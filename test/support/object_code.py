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

"""What a kernel's machine code shares with the process: read from its ELF object."""
import struct

SYMBOL_TABLE, FUNCTION, WEAK = 2, 2, 2


def weak_functions(code):
    """Return the names of an object's functions of which a process keeps one for all callers."""
    assert code[:5] == b'\x7fELF\x02', 'not a 64-bit ELF object'
    start, = struct.unpack_from('<Q', code, 40)
    size, count = struct.unpack_from('<HH', code, 58)
    # Each as name, type, flags, address, offset, size, link, info, alignment, size of an entry.
    sections = [struct.unpack_from('<IIQQQQIIQQ', code, start + k * size) for k in range(count)]
    found = []
    for _, kind, _, _, offset, length, link, *_ in sections:
        if kind == SYMBOL_TABLE:
            names = sections[link][4]
            for name, info in struct.iter_unpack('<IB19x', code[offset:offset + length]):
                if info & 15 == FUNCTION and info >> 4 == WEAK:
                    begin = names + name
                    found.append(code[begin:code.index(b'\0', begin)].decode())
    return found
