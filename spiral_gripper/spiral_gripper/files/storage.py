# SPDX-License-Identifier: Apache-2.0
"""Reading of files up to a size limit, and atomic writing."""

from __future__ import annotations

import errno
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from spiral_core import SpiralError
from spiral_core.message import Message

# The shipped descriptions have a thousandth of this [byte], a bench test some hundredth.
LARGEST_FILE = 2_000_000

# Where the system's own words are less clear.
_REASONS = {
    errno.ENOENT: "there is no such file",
    errno.ENOSPC: "the disk is full",
    errno.ENAMETOOLONG: "its name is too long",
    errno.ELOOP: "its links lead in a circle",
    errno.EEXIST: "it exists already and is kept; name another file",
    errno.EIO: "the device reports a failure",
}


class FileError(SpiralError):
    """A file cannot be read or written.

    Attributes:
        path: the file.
        action: ``"read"`` or ``"written"``.
        reason: why not, in words.

    Example:
        >>> print(FileError("mine.yaml", "written", "the disk is full"))
        mine.yaml cannot be written: the disk is full
    """

    def __init__(self, path: str, action: str, reason: str) -> None:
        super().__init__(path, action, reason)
        self.path = path
        self.action = action
        self.reason = reason

    def __str__(self) -> str:
        return Message("{} cannot be {}: {}", self.path, self.action, self.reason)


def reason_of(error: OSError) -> str:
    """Return the reason of an operating system's error in words.

    Example:
        >>> reason_of(OSError(errno.ENOSPC, "No space left on device"))
        'the disk is full'
    """
    known = _REASONS.get(error.errno or 0)
    return known or (error.strerror or "the system gives no reason").lower()


def read_text(path: Path, most: int = LARGEST_FILE) -> str:
    """Return the text of a plain file of at most so many bytes, in UTF-8.

    Raises:
        FileError: there is no such file, it is a device or a pipe, too large, or not UTF-8 text.
    """
    with _reasons_of(path, "read"):
        if path.exists() and not path.is_file():  # a pipe without a writer would block
            other = "it is a device or a pipe, not a plain file"
            raise FileError(str(path), "read", "it is a folder" if path.is_dir() else other)
        with path.open("rb") as file:
            data = file.read(most + 1)
    if len(data) > most:
        limit = f"it has more than {most / 1e6:g} MB"
        raise FileError(str(path), "read", f"{limit}, the most that is read")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        reason = f"it is not text in UTF-8 (byte {error.start + 1} is 0x{data[error.start]:02x})"
        raise FileError(str(path), "read", reason) from None


def write_file(path: Path, content: str | bytes, *, replace: bool = True) -> None:
    """Write a file atomically: completely, or not at all.

    The content goes to a temporary file beside it, which then takes its name.

    Args:
        path: the file.
        content: text, written in UTF-8, or bytes.
        replace: whether a file of this name may be replaced.

    Raises:
        FileError: the file exists and may not be replaced, or it cannot be written.
    """
    data = content.encode("utf-8") if isinstance(content, str) else content
    with _reasons_of(path, "written"):
        target = Path(os.path.realpath(path))  # a link stays a link
        if target.exists() and not target.is_file():
            raise FileError(str(path), "written", "it is not a plain file")
        if not target.parent.is_dir():
            raise FileError(str(path), "written", f"there is no folder {str(path.parent)!r}")
        if not replace:
            target.open("xb").close()  # keeps the name from now on
        temporary = target.with_name(f".{secrets.token_hex(6)}.tmp")
        try:
            with temporary.open("xb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(target)
        except BaseException:
            temporary.unlink(missing_ok=True)
            if not replace:
                target.unlink(missing_ok=True)
            raise


@contextmanager
def _reasons_of(path: Path, action: str) -> Iterator[None]:
    """Turn what the operating system reports into a FileError."""
    try:
        yield
    except OSError as error:
        raise FileError(str(path), action, reason_of(error)) from None
    except ValueError:
        raise FileError(repr(str(path)), action, "its name holds a null character") from None
