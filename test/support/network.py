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
A network between two hosts that are namespaces of this one, in a program of its own.

    unshare --net --mount python network.py [--loss P] [--delay SECONDS] [--seed N] [--shared]

Each host has a /dev/shm, a loopback and an interface of its own; --shared gives both the same
network, as that of two containers. The program prints the process ids by which to enter
them (setns), passes frames on until its standard input ends, and prints how many and how many
it has lost. Both lines are JSON.
"""
import argparse
from collections import deque
import contextlib
import ctypes
import fcntl
import json
import os
import random
import select
import socket
import struct
import subprocess
import sys
import time

NEW_MOUNTS, NEW_NETWORK = 0x20000, 0x40000000  # of unshare(2)
TAP, NO_HEADER, SET_INTERFACE = 0x0002, 0x1000, 0x400454ca  # of linux/if_tun.h
SET_FLAGS, SET_ADDRESS, SET_MASK, SET_QUEUE = 0x8914, 0x8916, 0x891c, 0x8943  # linux/sockios.h
UP, BROADCAST, LOOPBACK, RUNNING, MULTICAST = 0x1, 0x2, 0x8, 0x40, 0x1000  # of linux/if.h
ADDRESSES = ('10.77.0.1', '10.77.0.2')
SHM = '64m'  # as of a container for which nothing else is asked
LARGEST_FRAME, AT_ONCE = 2048, 64


def switch_on(name, address, mask, flags):
    """Give an interface an address and switch it on."""
    def dotted(number):
        return struct.pack('16sHH4s16x', name, socket.AF_INET, 0, socket.inet_aton(number))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as control:
        fcntl.ioctl(control, SET_ADDRESS, dotted(address))
        fcntl.ioctl(control, SET_MASK, dotted(mask))
        fcntl.ioctl(control, SET_FLAGS, struct.pack('16sH22x', name, UP | RUNNING | flags))


def open_tap(address):
    """Return the file descriptor of a new TAP interface in this process's network."""
    switch_on(b'lo', '127.0.0.1', '255.0.0.0', LOOPBACK)
    tap = os.open('/dev/net/tun', os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tap, SET_INTERFACE, struct.pack('16sH22x', b'eth0', TAP | NO_HEADER))
    with (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as control,
          contextlib.suppress(PermissionError)):  # only who is root outside may
        fcntl.ioctl(control, SET_QUEUE, struct.pack('16si20x', b'eth0', 10_000))
    switch_on(b'eth0', address, '255.255.255.0', BROADCAST | MULTICAST)
    return tap


def leave(namespaces):
    """Give this process new namespaces, and a /dev/shm of its own."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(namespaces):
        raise OSError(ctypes.get_errno(), 'unshare')
    subprocess.run(['mount', '-t', 'tmpfs', '-o', f'size={SHM}', 'shm', '/dev/shm'], check=True)


def make_host(address):
    """
    Fork a process that is a host for as long as this one lives.

    address: of its interface; None: it shares this process's network. Return its id, the socket
    that holds it, and a list of its TAP, if it has one.
    """
    ours, theirs = socket.socketpair()
    child = os.fork()
    if child:
        theirs.close()
        _, taps, _, _ = socket.recv_fds(ours, 1, 1)
        return child, ours, list(taps)
    ours.close()
    leave(NEW_MOUNTS | (NEW_NETWORK if address else 0))
    taps = [open_tap(address)] if address else []
    socket.send_fds(theirs, [b'.'], taps)
    theirs.recv(1)
    os._exit(0)


def frames_of(tap):
    """Return the frames that are there to be read."""
    frames = []
    try:
        while len(frames) < AT_ONCE:
            frames.append(os.read(tap, LARGEST_FRAME))
    except BlockingIOError:
        pass
    return frames


def relay(taps, loss, delay, seed):
    """Pass frames on until the standard input ends; return how many were passed and lost."""
    draw = random.Random(seed).random
    other = dict(zip(taps, reversed(taps), strict=True))
    late = deque()
    passed = lost = 0
    poll = select.poll()
    for readable in (*taps, sys.stdin.fileno()):
        poll.register(readable, select.POLLIN)
    while True:
        wait = max(0.0, late[0][0] - time.monotonic()) * 1000 if late else None
        for readable, _ in poll.poll(wait):
            if readable not in other:
                return passed, lost
            due = time.monotonic() + delay
            frames = frames_of(readable)
            kept = [frame for frame in frames if draw() >= loss]
            lost += len(frames) - len(kept)
            late.extend((due, other[readable], frame) for frame in kept)
        now = time.monotonic()
        while late and late[0][0] <= now:
            _, tap, frame = late.popleft()
            os.write(tap, frame)
            passed += 1


def main():
    """Make the hosts and their network."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--loss', type=float, default=0.0)
    parser.add_argument('--delay', type=float, default=0.0)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--shared', action='store_true')
    options = parser.parse_args()
    if options.shared:
        # A TAP without another end: the interface by which both find one another.
        lone = [open_tap(ADDRESSES[0])]
        hosts = [make_host(None) for _ in ADDRESSES]
    else:
        lone = []
        hosts = [make_host(address) for address in ADDRESSES]
    print(json.dumps([child for child, _, _ in hosts]), flush=True)
    if lone:
        sys.stdin.read()
        figures = 0, 0
    else:
        figures = relay([tap for _, _, taps in hosts for tap in taps], options.loss,
                        options.delay, options.seed)
    for _, held, _ in hosts:  # all of them first: a later host has inherited those before it
        held.close()
    for child, _, _ in hosts:
        os.waitpid(child, 0)
    print(json.dumps(figures), flush=True)


if __name__ == '__main__':
    main()
