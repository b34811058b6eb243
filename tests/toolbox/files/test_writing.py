"""What cannot be written is named as the user knows it, not by the temporary file beside it."""

import errno
import os
import shutil
import stat

import pytest

from ekfslam_tutorial.toolbox.files.writing import replacing

FULL = errno.ENOSPC, os.strerror(errno.ENOSPC)


@pytest.mark.parametrize("names", [lambda source, part: (), lambda source, part: (source, None, part)])
def test_a_full_disk_names_the_file_that_was_to_be_written(tmp_path, names):
    """Writing knows no name at all, copying the temporary one."""
    path = tmp_path / "map.csv"
    with pytest.raises(OSError, match="No space") as caught, replacing(path) as part:
        raise OSError(*FULL, *names("source.csv", str(part)))
    assert caught.value.filename == str(path) and caught.value.filename2 is None and not list(tmp_path.iterdir())


@pytest.mark.parametrize("place", ["nowhere/talk.html", "."])
def test_a_place_where_nothing_can_be_written(tmp_path, place):
    with pytest.raises(OSError) as caught, replacing(tmp_path / place) as part:
        part.write_text("slides")
    assert caught.value.filename == str(tmp_path / place)


def test_other_files_and_other_words_stay_as_they_are(tmp_path):
    with pytest.raises(FileNotFoundError) as caught, replacing(tmp_path / "copy") as part:
        shutil.copyfile(tmp_path / "source", part)
    assert caught.value.filename == str(tmp_path / "source")
    with pytest.raises(ConnectionError, match="^the host is gone$"), replacing(tmp_path / "copy"):
        raise ConnectionError("the host is gone")


def test_where_the_mask_leaves_the_owner_nothing_the_file_can_still_be_read(tmp_path, monkeypatch):
    """As in Python in a browser."""
    monkeypatch.setattr(os, "umask", lambda mask: 0o777)
    with replacing(tmp_path / "a.txt") as part:
        part.write_text("x")
    assert stat.S_IMODE((tmp_path / "a.txt").stat().st_mode) & 0o600 == 0o600
