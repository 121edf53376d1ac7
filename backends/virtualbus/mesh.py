"""One node of a channel, joined to every other node directly: no broker that could die."""

from __future__ import annotations

import contextlib
import errno
import select
import socket
import threading
from dataclasses import dataclass
from time import monotonic

from backends.frames import SIZE, overflow_frame
from backends.virtualbus.rendezvous import alone, connect_others, leave, listen

HELLO = b"+"  # the acceptor has us on its list; shorter than a frame, so never taken for one
HELLO_TIMEOUT = 1.0  # s; a stopped process must not keep others from joining
COARSE = 0.02  # s above which epoll's own time-out, in whole milliseconds, is fine enough
LARGEST = 64 * 1024  # bytes of one packet
FULL = (errno.EAGAIN, errno.ENOBUFS, errno.ENOMEM)


@dataclass(eq=False)
class _Peer:
    socket: socket.socket
    speaks: bool = False  # has sent something: not a mere listener
    missed: int = 0  # packets lost because its queue was full


class Mesh:
    """Packets to and from all other nodes of a channel.

    ``send`` may be called from any thread, ``receive`` from one at a time.
    """

    def __init__(self, channel: str, send_buffer: int | None = None) -> None:
        self._send_buffer = send_buffer
        self._peers: tuple[_Peer, ...] = ()
        self._by_fd: dict[int, _Peer] = {}
        self._lock = threading.Lock()
        self._epoll = select.epoll()
        self._closed = False
        self._conversation = False  # somebody other than us has sent something
        self.deserted = False  # everybody who ever spoke has left, and all of it was heard
        self._channel = channel
        with alone(channel) as folder:
            self._listener, self._path = listen(folder)
            for connection in connect_others(folder, self._path):
                self._await_hello(connection)
            self._thread = threading.Thread(
                target=self._accept, name=f"virtualbus {channel}", daemon=True
            )
            self._thread.start()

    def send(self, packet: bytes) -> None:
        """To every node. A node that alone cannot keep up loses the packet and is told so later by
        an error frame. If no node has room the sender is told: OSError(ENOBUFS). Where others than
        mere listeners are or were on the bus, it is they who count."""
        peers, full = self._peers, []
        for peer in peers:
            try:
                if peer.missed:
                    peer.socket.send(overflow_frame())
                    peer.missed = 0
                peer.socket.send(packet)
            except OSError as error:
                if error.errno in FULL:
                    full.append(peer)
                else:
                    self._tell_no_more(peer)
        if not full:
            return
        counting = [peer for peer in peers if peer.speaks or not self._conversation]
        if counting and all(peer in full for peer in counting):
            raise OSError(errno.ENOBUFS, "no node on the bus takes frames: every queue is full")
        for peer in full:
            peer.missed += 1

    def receive(self, timeout: float | None) -> bytes:
        """The next packets, joined; empty after ``timeout`` seconds (None: wait for ever)."""
        if self._closed:
            raise OSError(errno.EBADF, "the bus is closed")
        deadline = None if timeout is None else monotonic() + timeout
        while True:
            packets = [self._take(self._by_fd.get(fd)) for fd, _ in self._wait(timeout)]
            if packet := b"".join(packets):
                return packet
            if self._closed:
                raise OSError(errno.EBADF, "the bus is closed")
            if deadline is not None:
                timeout = deadline - monotonic()
                if timeout <= 0:
                    return b""

    def close(self) -> None:
        """Leave the channel."""
        if self._closed:
            return
        self._closed = True
        leave(self._channel, self._path)
        self._listener.shutdown(socket.SHUT_RDWR)  # wakes the accepting thread
        self._thread.join()
        self._listener.close()
        for peer in tuple(self._by_fd.values()):
            self._drop(peer)
        self._epoll.close()

    def _wait(self, timeout: float | None) -> list[tuple[int, int]]:
        if timeout is None or timeout > COARSE or timeout <= 0:
            return self._epoll.poll(timeout)
        select.select((self._epoll,), (), (), timeout)
        return self._epoll.poll(0)

    def _take(self, peer: _Peer | None) -> bytes:
        if peer is None:
            return b""
        try:
            packet = peer.socket.recv(LARGEST)
        except BlockingIOError:
            return b""
        except OSError:
            packet = b""
        if not packet:
            self._drop(peer)
            return b""
        if len(packet) % SIZE:
            return b""  # a late HELLO
        if not peer.speaks:
            peer.speaks, self.deserted = True, False
            self._conversation = True
            self._arrange()
        return packet

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            self._join(connection)
            with contextlib.suppress(OSError):  # it left already: the next receive notices
                connection.send(HELLO)

    def _await_hello(self, connection: socket.socket) -> None:
        connection.settimeout(HELLO_TIMEOUT)
        try:
            hello = connection.recv(LARGEST)
        except TimeoutError:
            pass
        except OSError:
            connection.close()
            return
        else:
            if not hello:
                connection.close()
                return
        self._join(connection)

    def _join(self, connection: socket.socket) -> None:
        connection.setblocking(False)
        if self._send_buffer is not None:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, self._send_buffer)
        peer = _Peer(connection)
        with self._lock:
            self._by_fd[connection.fileno()] = peer
            self._epoll.register(connection, select.EPOLLIN)
            self._peers = (peer, *self._peers)

    def _tell_no_more(self, peer: _Peer) -> None:
        """It left. What it said before was on the bus and is still to be heard."""
        with self._lock:
            self._peers = tuple(p for p in self._peers if p is not peer)

    def _drop(self, peer: _Peer) -> None:
        self._tell_no_more(peer)
        with self._lock:
            if self._by_fd.pop(peer.socket.fileno(), None) is None:
                return
            self._epoll.unregister(peer.socket)
            peer.socket.close()
            speaking = any(other.speaks for other in self._by_fd.values())
            self.deserted = self._conversation and not speaking

    def _arrange(self) -> None:
        """Listeners first, so that in their log no answer overtakes the question."""
        with self._lock:
            self._peers = tuple(sorted(self._peers, key=lambda peer: peer.speaks))
