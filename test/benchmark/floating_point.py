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

"""What one processor can reckon at most, and what a step of the cloth asks of it."""
import time

from flag_sim.jit.kernels import wide_kernel
import numpy as np

SPRING = (
    3 + 5        # vector between the ends, its square
    + 2          # 1 / length: a root and a division
    + 3 + 5      # relative velocity, times the vector
    + 2          # k - (k rest) / length
    + 3 + 1 + 1  # + c rate / length^2, times its share of the sheet
    + 3 + 6)     # times the vector, to one end and from the other
FACE = (
    6            # two sides
    + 9 + 3      # half their vector product
    + 3          # velocity of the side that two faces share: 6 for both
    + 9 + 5      # wind against the face, times the area vector
    + 5          # square of the area
    + 2 + 2 + 3  # 1 + hold |flux|; drag |flux| flux; divided by both, halved
    + 3          # times the area vector
    + 3 + 9)     # half of it, and the sums of three corners
GRAVITY = 1      # g m
STEP = (
    1            # dt / m
    + 9          # velocity: + (dt / m) F, times what node damping leaves
    + 6)         # position: + dt v
FLOPS = 4 * SPRING + 2 * FACE + GRAVITY + STEP
"""
Floating-point operations that the model needs for a node and step, each spring and face once.

A root and a division count as one each, a fused multiply-add as two. A program may do more (ours
sums each spring at both of its ends rather than scatter); that is no merit and is not counted.
"""

CHAIN = 64
LANES = 2048  # numbers of each of the two arrays: both stay in the nearest cache


@wide_kernel(cache=False)
def multiply_add(a, b, factor, count):
    """Put every number through CHAIN multiply-adds, count times over."""
    for _ in range(count):
        for j in range(a.size):
            x, y = a[j], b[j]
            for _ in range(CHAIN // 2):
                x = x * factor + factor
                y = y * factor + factor
            a[j], b[j] = x, y


def _rate(work, flops, seconds=0.3):
    """Return the best rate of work() [flop/s] within some seconds."""
    work()
    best, end = 0.0, time.perf_counter() + seconds
    while (begin := time.perf_counter()) < end:
        work()
        best = max(best, flops / (time.perf_counter() - begin))
    return best


def peak(dtype):
    """
    Return the highest rate of a type [flop/s] that this processor was seen to reach.

    The better of a loop of multiply-adds in registers, compiled as the cloth's kernels are, and
    of BLAS's product of matrices, which is written by hand for each processor.
    """
    a, b = np.ones(LANES, dtype), np.ones(LANES, dtype)
    factor = a.dtype.type(0.5)
    m = np.ones((512, 512), dtype)
    out = np.empty_like(m)
    return max(_rate(lambda: multiply_add(a, b, factor, 100), 100 * LANES * CHAIN * 2),
               _rate(lambda: np.matmul(m, m, out=out), 2 * 512**3))
