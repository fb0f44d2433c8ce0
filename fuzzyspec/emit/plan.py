"""The files of one compilation as a value, and the one place that writes them."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Plan:
    """File names (no folders) and their bytes, sorted by name."""

    files: Mapping[str, bytes]

    def __post_init__(self) -> None:
        object.__setattr__(self, "files", dict(sorted(self.files.items())))

    @property
    def digest(self) -> str:
        """SHA-256 over names and contents."""
        whole = hashlib.sha256()
        for name, content in self.files.items():
            whole.update(f"{len(name)} {name} {len(content)} ".encode())
            whole.update(content)
        return whole.hexdigest()


def write(plan: Plan, directory: str | os.PathLike[str]) -> list[str]:
    """Write every file or none, and give the names written.

    All are first written beside their places and only then renamed over them, so that a full disk or a refusal leaves
    the old files as they were; where a rename fails, those before it are taken back. Of two that write into one folder
    at once the later waits, so that the files left are all of one of them. Raises OSError, which names the file or the
    folder that is at fault.
    """
    folder = Path(directory)
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(errno.ENOTDIR, "is a file, not a folder", str(folder))
    folder.mkdir(parents=True, exist_ok=True)
    for name in plan.files:
        if (folder / name).is_dir():
            raise IsADirectoryError(errno.EISDIR, "is a folder in the place of a file", str(folder / name))
    with _alone_in(folder):
        _replace_all(plan, folder)
    return list(plan.files)


def _replace_all(plan: Plan, folder: Path) -> None:
    beside: list[tuple[str, Path]] = []
    replaced: list[tuple[Path, bytes | None]] = []
    try:
        for name, content in plan.files.items():
            beside.append((_written_beside(folder / name, content), folder / name))
        for temporary, place in beside:
            before = _content(place)
            os.replace(temporary, place)
            replaced.append((place, before))
    except BaseException:
        for place, before in replaced:
            _restore(place, before)
        raise
    finally:
        for temporary, _ in beside:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(temporary)


@contextlib.contextmanager
def _alone_in(folder: Path) -> Iterator[None]:
    """Hold the folder against other writers; where its file system has no locks, go on without."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        with contextlib.suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def stale(plan: Plan, directory: str | os.PathLike[str]) -> list[str]:
    """The names whose file in the folder is missing or differs."""
    return [name for name, content in plan.files.items() if _content(Path(directory) / name) != content]


def _written_beside(place: Path, content: bytes) -> str:
    """Write to a new file in the same folder; its path. An OSError names ``place``, the file that the user knows."""
    try:
        handle, temporary = tempfile.mkstemp(prefix=f".{place.name}.", suffix=".new", dir=place.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(content)
            os.chmod(temporary, _mode(place))
        except BaseException:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(temporary)
            raise
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(place)) from error
    return temporary


def _restore(place: Path, content: bytes | None) -> None:
    with contextlib.suppress(OSError):
        if content is None:
            place.unlink()
        else:
            place.write_bytes(content)


def _mode(place: Path) -> int:
    """The mode of the file that is replaced, else what the umask leaves of 0666."""
    try:
        return place.stat().st_mode & 0o777
    except FileNotFoundError:
        mask = os.umask(0)
        os.umask(mask)
        return 0o666 & ~mask


def _content(place: Path) -> bytes | None:
    try:
        return place.read_bytes()
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        return None
