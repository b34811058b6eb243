"""Servers on loopback that hand out one file, in good and in bad ways."""

import contextlib
import http.server
import re
import socketserver
import threading
import time


class Handler(http.server.BaseHTTPRequestHandler):
    """Answers as `server.manner` says; `server.asked` notes the range of each request."""

    def do_GET(self):
        manner, data = self.server.manner, self.server.data
        asked = re.fullmatch(r"bytes=(\d+)-", self.headers.get("Range", ""))
        fits = self.headers.get("If-Range") == self.server.tag
        self.server.asked.append(int(asked[1]) if asked else 0)
        start = int(asked[1]) if asked and fits and "no range" not in manner else 0
        if "missing" in manner:
            return self.send_error(404)
        if "page" in manner:
            data = b"<!DOCTYPE html><html><body>Please log in</body></html>"
        if start and start >= len(data):
            return self.send_error(416)
        self.send_response(206 if start else 200)
        if start:
            self.send_header("Content-Range", f"bytes {start}-{len(data) - 1}/{len(data)}")
        if "no length" not in manner:
            self.send_header("Content-Length", str(len(data) - start))
        if "no tag" not in manner:
            self.send_header("ETag", self.server.tag)
        self.end_headers()
        end = len(data)
        if "breaks" in manner:
            end = start + (len(data) - start) // 2
        pieces = range(start, end, 20_000)
        for at in pieces:
            self.wfile.write(data[at : min(at + 20_000, end)])
            if "slow" in manner:
                time.sleep(0.02)
        self.close_connection = True
        if "heals" in manner:
            self.server.manner = manner - {"breaks", "heals"}

    def log_message(self, format, *args):
        """Say nothing."""


@contextlib.contextmanager
def _running(kind, handler, data, manner):
    """A server of this kind, on a free port of loopback, at work in a thread."""
    with kind(("127.0.0.1", 0), handler) as server:
        server.data, server.manner, server.asked = data, set(manner), []
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


@contextlib.contextmanager
def serve(data, *manner):
    """A server of these bytes; its address is `server.url`."""
    with _running(http.server.ThreadingHTTPServer, Handler, data, manner) as server:
        server.tag = '"first"'
        server.url = f"http://127.0.0.1:{server.server_address[1]}/file"
        yield server


class FtpHandler(socketserver.StreamRequestHandler):
    """As much of FTP as a download takes."""

    def handle(self):
        server, rest, passive = self.server, 0, None
        self._say("220 ready")
        while line := self.rfile.readline().decode().strip():
            word, _, value = line.partition(" ")
            if word == "PASV":
                passive = socketserver.TCPServer(("127.0.0.1", 0), socketserver.BaseRequestHandler)
                self._say("227 passive (127,0,0,1,{},{})".format(*divmod(passive.server_address[1], 256)))
            elif word == "SIZE":
                self._say(f"213 {len(server.data)}" if value == server.path else "550 no such file")
            elif word == "REST":
                rest = int(value)
                server.asked.append(rest)
                self._say("350 go on")
            elif word == "RETR":
                self._say("150 here it is")
                connection, _ = passive.get_request()
                end = len(server.data) if "breaks" not in server.manner else rest + (len(server.data) - rest) // 2
                connection.sendall(server.data[rest:end])
                connection.close()
                passive.server_close()
                self._say("226 done" if end == len(server.data) else "426 broken off")
            else:
                self._say({"USER": "331 who", "PASS": "230 welcome", "QUIT": "221 bye"}.get(word, "200 fine"))
                if word == "QUIT":
                    return

    def _say(self, text):
        with contextlib.suppress(OSError):
            self.wfile.write(text.encode() + b"\r\n")


@contextlib.contextmanager
def serve_ftp(data, *manner):
    """The same by FTP."""
    socketserver.ThreadingTCPServer.daemon_threads = True
    with _running(socketserver.ThreadingTCPServer, FtpHandler, data, manner) as server:
        server.path = "/MRCLAM/file.zip"
        server.url = f"ftp://127.0.0.1:{server.server_address[1]}{server.path}"
        yield server
