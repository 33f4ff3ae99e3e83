"""The data folder is used by one server at a time."""

from pathlib import Path

import pytest

from service.store.data_folder import FolderInUseError, opened


def test_a_folder_is_opened_once_at_a_time(tmp_path: Path) -> None:
    with opened(tmp_path / "data") as folder:
        assert folder.incoming.is_dir()
        with pytest.raises(FolderInUseError, match="another server uses"), opened(tmp_path / "data"):
            pass
    with opened(tmp_path / "data"):
        pass


def test_half_read_bodies_are_cleared_away_and_nothing_else(tmp_path: Path) -> None:
    with opened(tmp_path) as folder:
        (folder.incoming / "body-x").write_bytes(b"half")
        folder.database.write_bytes(b"kept")
    with opened(tmp_path) as folder:
        assert not list(folder.incoming.iterdir())
        assert folder.database.read_bytes() == b"kept"
