"""The user of a device that datagrams move, for tests."""

import os
import socket
import threading

import numpy as np


def free_address() -> str:
    """An address of this machine that nobody listens on."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return f"127.0.0.1:{probe.getsockname()[1]}"


class DeviceUser:
    """Moves the device `pointer`, and feels its force."""

    def __init__(self, **params):
        self.address = free_address()
        self.params = {"address": self.address, "hold": 3600} | params
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setblocking(False)
        # The largest force so far, N.
        self.largest = 0.0

    def send(self, position, buttons=0):
        """Move to a place (m, axes of the device) with these buttons."""
        host, port = self.address.split(":")
        text = " ".join(repr(float(c)) for c in position) + f" {buttons}"
        self.socket.sendto(text.encode(), (host, int(port)))

    def force(self):
        """The force on the device since the last call, N (3); None if it said nothing."""
        last = None
        while True:
            try:
                last = np.array([float(c) for c in self.socket.recv(256).split()])
            except BlockingIOError:
                return last
            self.largest = max(self.largest, float(np.linalg.norm(last)))

    def go(self, hand, position, buttons=0, views=3):
        """Move there and wait until the session has seen it and `views` more views."""
        self.send(position, buttons)
        seen = hand.wait()
        for _ in range(views + 2):
            seen = hand.wait(seen, 20.0)
            self.force()

    def glide(self, hand, start, end, buttons=0, count=20):
        """Move along a line."""
        for share in np.linspace(0.0, 1.0, count):
            self.go(hand, (1 - share) * np.asarray(start) + share * np.asarray(end), buttons, views=0)
        self.go(hand, end, buttons)

    def close(self):
        """Move no more."""
        self.socket.close()


def thread_names() -> list[str]:
    """Names of the threads of this process, those of Python and native ones."""
    if not os.path.isdir("/proc/self/task"):
        return [thread.name for thread in threading.enumerate()]
    names = []
    for task in os.listdir("/proc/self/task"):
        try:
            with open(f"/proc/self/task/{task}/comm") as file:
                names.append(file.read().strip())
        except FileNotFoundError:
            # It has ended.
            continue
    return names


def is_free(address: str) -> bool:
    """Whether nobody listens on an address: a device that is closed has given it back."""
    host, port = address.split(":")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind((host, int(port)))
        except OSError:
            return False
    return True


def thread_ids(name: str) -> set[str]:
    """Ids of the threads of this process that have a name; none where the system does not list them."""
    if not os.path.isdir("/proc/self/task"):
        return set()
    found = set()
    for task in os.listdir("/proc/self/task"):
        try:
            with open(f"/proc/self/task/{task}/comm") as file:
                if file.read().strip() == name:
                    found.add(task)
        except FileNotFoundError:
            # It has ended.
            continue
    return found
