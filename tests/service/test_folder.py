"""The data folder is used by one server at a time."""

from pathlib import Path

import pytest

from service.store.data_folder import FolderDeniedError, FolderInUseError, opened


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


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "incoming").write_bytes(b"a file where there should be a folder")
    with (
        pytest.raises(FolderDeniedError, match=r"incoming cannot be written by user \d+ of group \d+"),
        opened(tmp_path),
    ):
        pass


def test_a_folder_made_for_a_group_stays_the_groups_and_nobody_elses(tmp_path: Path) -> None:
    """Volumes of containers belong to a group, and the user who writes to them may be any."""
    tmp_path.chmod(0o777)
    with opened(tmp_path) as folder:
        assert oct(folder.path.stat().st_mode & 0o777) == "0o770"
        assert oct(folder.incoming.stat().st_mode & 0o777) == "0o700"
