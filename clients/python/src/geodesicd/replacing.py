"""A file that takes another's place when it is whole."""

from __future__ import annotations

import errno
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def replaced(file: Path) -> Iterator[Path]:
    """The name of an empty file beside ``file``, which takes its place, and its rights, at the end
    of the ``with``. If that ends by an exception, what was there stays.

    Raises:
        OSError: it cannot be written; the message names ``file``.
    """
    place = file.resolve()
    fresh: Path | None = None
    try:
        if place.exists() and not os.access(place, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(file))
        handle, name = tempfile.mkstemp(prefix=f".{place.name}.", dir=place.parent)
        os.close(handle)
        fresh = Path(name)
        yield fresh
        rights = stat.S_IMODE(place.stat().st_mode) if place.exists() else 0o666 & ~_masked()
        fresh.chmod(rights)
        fresh.replace(place)
    except BaseException as error:
        if fresh is not None:
            fresh.unlink(missing_ok=True)
        # Errors of writing name no file, those of making one the one beside it.
        ours = fresh is None or getattr(error, "filename", None) in (None, str(fresh))
        if isinstance(error, OSError) and error.errno and ours:
            raise type(error)(error.errno, error.strerror, str(file)) from None
        raise


def _masked() -> int:
    """The rights that new files are not to have."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask
