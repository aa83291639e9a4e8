"""What the library throws, as Python exceptions."""

from __future__ import annotations


class Error(Exception):
    """Anything that ptet refuses or fails at.

    Attributes:
        offset: the byte of the file where the reader stood, or None when the error is not about a place in a file.
    """

    def __init__(self, message: str, offset: int | None = None) -> None:
        super().__init__(message)
        self.offset = offset

    def __str__(self) -> str:
        return str(self.args[0])


class ArgumentError(Error, ValueError):
    """An argument that makes no sense: an unknown field, a negative bound, an array of the wrong shape or type."""


class InputError(Error, ValueError):
    """A mesh or field that cannot be handled: ids out of range, values that are not finite, overlapping tets."""


class FormatError(Error):
    """A .ptet file that breaks its specification; `offset` tells where."""


class LimitError(Error):
    """A limit of size or memory that would be passed."""


class FileError(Error, OSError):
    """Reading or writing failed: the operating system, or the object that was to give the bytes."""


class MissingFileError(FileError, FileNotFoundError):
    """There is no such file to open."""


class Cancelled(Error):
    """The progress callback returned False."""


class UnmetWarning(UserWarning):
    """A request asks for something that is not in the mesh: a focus beside it, values that it does
    not have, a view that looks past it."""
