"""A download that goes on where it broke off, by HTTP or FTP: the downloader that `fetch` gives to pooch."""

import ftplib
import json
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlsplit

PIECE = 2**16
TIMEOUT = (10.0, 30.0)
"""Seconds to wait for a connection, and for the next bytes."""

LIMIT = 2**31
"""Bytes of one file; a server that sends more does not send what was asked for."""


class BrokenOff(ConnectionError):
    """The transfer ended before the file did; what has come is kept."""


@dataclass
class Resuming:
    """Downloads a file through `part`, which stays there when the transfer breaks off and is gone on with next time.

    Parameters
    ----------
    part : Path
        The unfinished file. What the server says about the edition is kept beside it.
    check : callable
        Path -> None; raises ValueError if what came is not the file. The unfinished file is then removed.
    attempts : int
        Tries in a row, as long as a try brings something.
    pause : float
        Seconds between two tries.
    progress : callable, optional
        (bytes so far, bytes in all or None) -> None.
    """

    part: Path
    check: Callable
    attempts: int = 3
    pause: float = 1.0
    progress: Callable | None = None

    def __call__(self, url, output_file, pooch=None):
        """As pooch calls it: the whole file is at `output_file` then, or an exception is raised."""
        transfer = _ftp if urlsplit(url).scheme == "ftp" else _http
        for attempt in range(1, self.attempts + 1):
            try:
                transfer(url, self)
                break
            except BrokenOff:
                if attempt == self.attempts:
                    raise
                time.sleep(self.pause)
        try:
            self.check(self.part)
        except ValueError:
            self.forget()
            raise
        os.replace(self.part, output_file)
        self.forget()

    def here(self):
        """Bytes that have come already."""
        return self.part.stat().st_size if self.part.exists() else 0

    def forget(self):
        """Remove the unfinished file and what is known about it."""
        self.part.unlink(missing_ok=True)
        self._note().unlink(missing_ok=True)

    def edition(self, url):
        """Return what the server said about the edition of the unfinished file, None if nothing."""
        try:
            note = json.loads(self._note().read_text())
            return note["edition"] if note["url"] == url else None
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def note_edition(self, url, edition):
        """Keep that for the next time."""
        self._note().write_text(json.dumps({"url": url, "edition": edition}))

    def take(self, pieces, start, total):
        """Append pieces from byte `start` on; `total` is the length of the whole file, if known."""
        done = start
        with open(self.part, "r+b" if start else "wb") as file:
            file.truncate(start)
            file.seek(start)
            for piece in pieces:
                done += len(piece)
                if done > min(LIMIT, total or LIMIT):
                    raise ValueError("the server sends more than the file should have")
                file.write(piece)
                if self.progress is not None:
                    self.progress(done, total)
        if total is not None and done < total:
            raise BrokenOff(f"the transfer broke off after {done} of {total} bytes")

    def _note(self):
        return self.part.with_name(self.part.name + ".json")


def _http(url, job):
    """One try by HTTP: the rest of the file if the server can give it, else all of it."""
    import requests

    start, edition = job.here(), job.edition(url)
    if edition is None:  # nobody can say whether the rest would fit
        start = 0
    headers = {"Accept-Encoding": "identity"} | ({"Range": f"bytes={start}-", "If-Range": edition} if start else {})
    try:
        with requests.get(url, headers=headers, stream=True, timeout=TIMEOUT) as answer:
            if answer.status_code == 416:  # the file has no such rest
                job.forget()
                raise BrokenOff("the server has no rest of what has come so far")
            answer.raise_for_status()
            said, length = answer.headers.get("Content-Range", ""), answer.headers.get("Content-Length", "")
            goes_on = answer.status_code == 206 and said.startswith(f"bytes {start}-")
            start = start if goes_on else 0
            total = start + int(length) if length.isdecimal() else None
            tag = answer.headers.get("ETag", "")
            job.note_edition(url, (tag if tag.startswith('"') else "") or answer.headers.get("Last-Modified"))
            job.take(answer.iter_content(PIECE), start, total)
    except requests.exceptions.ConnectionError as error:
        raise BrokenOff(_reason(error)) from error
    except (requests.exceptions.ChunkedEncodingError, requests.exceptions.Timeout) as error:
        raise BrokenOff(_reason(error)) from error


def _ftp(url, job):
    """One try by FTP."""
    address, start = urlsplit(url), job.here()
    try:
        with ftplib.FTP(timeout=TIMEOUT[1]) as ftp:  # the publisher offers nothing else
            ftp.connect(address.hostname or "", address.port or 21)
            ftp.login()
            ftp.voidcmd("TYPE I")
            total = ftp.size(unquote(address.path))
            if total is not None and start > total or job.edition(url) != str(total):
                start = 0
            job.note_edition(url, str(total))
            with ftp.transfercmd(f"RETR {unquote(address.path)}", rest=start or None) as data:
                job.take(iter(lambda: data.recv(PIECE), b""), start, total)
            ftp.voidresp()
    except ftplib.error_perm as error:
        raise ConnectionError(f"the server says {str(error)[:100]!r}") from error
    except ConnectionError:
        raise
    except (OSError, EOFError, ftplib.Error) as error:
        raise BrokenOff(_reason(error)) from error


def _reason(error):
    """Why it failed, in few words."""
    return " ".join(str(error).split())[:160] or type(error).__name__
