"""Files are written all or none, and told apart when stale."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from fuzzyspec.emit import Plan, stale, write

OLD = Plan({"b.c": b"old b", "a.h": b"old a"})
NEW = Plan({"b.c": b"new b", "a.h": b"new a", "c.c": b"new c"})


def _content(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir()}


def test_files_are_sorted_and_digested() -> None:
    """The order in which files were added changes neither the plan nor its digest; their bytes do."""
    assert list(OLD.files) == ["a.h", "b.c"]
    assert OLD.digest == Plan({"a.h": b"old a", "b.c": b"old b"}).digest
    assert len({OLD.digest, NEW.digest, Plan({"a.h": b"old a", "b.c": b"old "}).digest}) == 3


def test_written_files_are_fresh(tmp_path: Path) -> None:
    """Folders are made, old content is replaced, nothing else is left behind."""
    folder = tmp_path / "new" / "folder"
    assert write(OLD, folder) == ["a.h", "b.c"]
    assert stale(OLD, folder) == []
    assert stale(NEW, folder) == ["a.h", "b.c", "c.c"]
    write(NEW, folder)
    assert _content(folder) == dict(NEW.files)


def test_stale_looks_without_touching(tmp_path: Path) -> None:
    """A missing folder, a missing file and a changed byte are stale, and stay as they are."""
    assert stale(OLD, tmp_path / "none") == ["a.h", "b.c"]
    assert not (tmp_path / "none").exists()
    (tmp_path / "a.h").write_bytes(b"old a")
    (tmp_path / "b.c").write_bytes(b"old b\r\n")
    assert stale(OLD, tmp_path) == ["b.c"]


@pytest.mark.parametrize("fails_at", [1, 2, 3])
@pytest.mark.parametrize("what", ["replace", "write"])
def test_a_failure_leaves_the_old_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, what: str, fails_at: int
) -> None:
    """A disk that is full at any file, or a rename that fails, leaves what was there and nothing beside it."""
    write(OLD, tmp_path)
    real = {"replace": os.replace, "write": os.fdopen}[what]
    calls = 0

    def failing(*arguments: object) -> object:
        nonlocal calls
        calls += 1
        if calls == fails_at:
            raise OSError(28, "No space left on device")
        return real(*arguments)  # type: ignore[operator]

    monkeypatch.setattr(os, "replace" if what == "replace" else "fdopen", failing)
    with pytest.raises(OSError, match="No space left"):
        write(NEW, tmp_path)
    monkeypatch.undo()
    assert _content(tmp_path) == dict(OLD.files)


def test_a_file_in_the_folders_place_is_named(tmp_path: Path) -> None:
    """A directory that is a file, and a file that is a directory, are refused before anything is written."""
    (tmp_path / "out").write_text("here first")
    with pytest.raises(NotADirectoryError, match=r"is a file.*out"):
        write(OLD, tmp_path / "out")
    (tmp_path / "b.c").mkdir()
    with pytest.raises(IsADirectoryError, match=r"b\.c"):
        write(OLD, tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["b.c", "out"]


def test_modes_are_those_of_ordinary_files(tmp_path: Path) -> None:
    """A new file has what the umask leaves, a replaced one keeps its mode."""
    (tmp_path / "a.h").write_bytes(b"")
    (tmp_path / "a.h").chmod(0o640)
    mask = os.umask(0o027)
    try:
        write(OLD, tmp_path)
    finally:
        os.umask(mask)
    assert (tmp_path / "a.h").stat().st_mode & 0o777 == 0o640
    assert (tmp_path / "b.c").stat().st_mode & 0o777 == 0o640
