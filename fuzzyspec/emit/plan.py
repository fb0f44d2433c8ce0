"""The files of one compilation as a value, and the one place that writes them."""

from __future__ import annotations

import contextlib
import hashlib
import os
import tempfile
from collections.abc import Mapping
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
    the old files as they were. Raises OSError.
    """
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    for name in plan.files:
        if (folder / name).is_dir():
            raise IsADirectoryError(21, "is a folder, but a file is to be written there", str(folder / name))
    beside: list[tuple[str, Path]] = []
    try:
        for name, content in plan.files.items():
            beside.append((_written_beside(folder, name, content), folder / name))
        for temporary, place in beside:
            os.replace(temporary, place)
    finally:
        for temporary, _ in beside:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(temporary)
    return list(plan.files)


def stale(plan: Plan, directory: str | os.PathLike[str]) -> list[str]:
    """The names whose file in the folder is missing or differs."""
    return [name for name, content in plan.files.items() if _content(Path(directory) / name) != content]


def _written_beside(folder: Path, name: str, content: bytes) -> str:
    handle, temporary = tempfile.mkstemp(prefix=f".{name}.", suffix=".new", dir=folder)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.chmod(temporary, _mode(folder / name))
    except BaseException:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(temporary)
        raise
    return temporary


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
