"""SDO server of a virtual drive: expedited and segmented transfers (CiA 301, 7.2.4)."""

from __future__ import annotations

from struct import Struct

from backends.virtual.drives.object_dictionary import (
    BAD_COMMAND,
    BAD_TOGGLE,
    OTHER_LENGTH,
    TOO_LONG,
    LiveDictionary,
    SdoAbort,
)

HEAD = Struct("<BHB")  # command, index, sub-index
ABORT = Struct("<BHBI")
LONGEST = 1024  # bytes of a string or domain

DOWNLOAD_SEGMENT, DOWNLOAD, UPLOAD, UPLOAD_SEGMENT, ABORTED = 0, 1, 2, 3, 4  # client, bits 5-7


class SdoServer:
    """Answers one client; a new initiate ends whatever transfer was under way."""

    def __init__(self, dictionary: LiveDictionary) -> None:
        self._dictionary = dictionary
        self._object = (0, 0)
        self._toggle = 0
        self._upload: bytes | None = None
        self._download: bytearray | None = None
        self._room = 0  # bytes that its object takes
        self._announced: int | None = None  # bytes that a download said it would have

    def answer(self, request: bytes) -> bytes | None:
        """The eight bytes to send back, or None where silence is right."""
        if len(request) != 8:
            return None
        command = request[0] >> 5
        try:
            if command == DOWNLOAD:
                return self._start_download(request)
            if command == UPLOAD:
                return self._start_upload(request)
            if command == DOWNLOAD_SEGMENT:
                return self._download_segment(request)
            if command == UPLOAD_SEGMENT:
                return self._upload_segment(request)
            self._upload = self._download = None
            if command == ABORTED:
                return None
            self._object = HEAD.unpack_from(request)[1:]
            raise SdoAbort(BAD_COMMAND)  # block transfer
        except SdoAbort as refusal:
            self._upload = self._download = None
            return ABORT.pack(0x80, *self._object, refusal.code)

    def _start_download(self, request: bytes) -> bytes:
        command, *address = HEAD.unpack_from(request)
        self._object = (address[0], address[1])
        self._upload = self._download = None
        if command & 2:  # expedited
            size = 4 - (command >> 2 & 3) if command & 1 else self._declared_size()
            self._dictionary.write(*self._object, request[4 : 4 + size])
        else:
            self._room = self._dictionary.entry(*self._object).size or LONGEST
            self._announced = int.from_bytes(request[4:], "little") if command & 1 else None
            if self._announced is not None and self._announced > self._room:
                raise SdoAbort(TOO_LONG)
            self._download, self._toggle = bytearray(), 0
        return HEAD.pack(0x60, *self._object).ljust(8, b"\0")

    def _declared_size(self) -> int:
        return min(self._dictionary.entry(*self._object).size or 4, 4)

    def _download_segment(self, request: bytes) -> bytes:
        if self._download is None:
            raise SdoAbort(BAD_COMMAND)
        self._flip(request[0])
        size = 7 - (request[0] >> 1 & 7)
        self._download += request[1 : 1 + size]
        if len(self._download) > self._room:
            raise SdoAbort(TOO_LONG)
        if request[0] & 1:
            data, self._download = bytes(self._download), None
            if self._announced not in (None, len(data)):
                raise SdoAbort(OTHER_LENGTH)
            self._dictionary.write(*self._object, data)
        return bytes([0x20 | request[0] & 0x10]).ljust(8, b"\0")

    def _start_upload(self, request: bytes) -> bytes:
        _, *address = HEAD.unpack_from(request)
        self._object = (address[0], address[1])
        self._upload = self._download = None
        data = self._dictionary.read(*self._object)
        if 1 <= len(data) <= 4:
            return HEAD.pack(0x43 | 4 - len(data) << 2, *self._object) + data.ljust(4, b"\0")
        self._upload, self._toggle = data, 0
        return HEAD.pack(0x41, *self._object) + len(data).to_bytes(4, "little")

    def _upload_segment(self, request: bytes) -> bytes:
        if self._upload is None:
            raise SdoAbort(BAD_COMMAND)
        self._flip(request[0])
        part, rest = self._upload[:7], self._upload[7:]
        self._upload = rest or None
        head = request[0] & 0x10 | 7 - len(part) << 1 | (not rest)
        return bytes([head]) + part.ljust(7, b"\0")

    def _flip(self, command: int) -> None:
        if command & 0x10 != self._toggle:
            raise SdoAbort(BAD_TOGGLE)
        self._toggle ^= 0x10
