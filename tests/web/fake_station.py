# SPDX-License-Identifier: Apache-2.0
"""A server that speaks as `panelcal serve` does, plays the states that a test sets, and records what arrives."""
import json
import re
import struct
import threading
import zlib
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs, urlparse

# As tools/serve sends it.
POLICY = ("default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
          "frame-src 'self'")
WIDTH_PX, HEIGHT_PX = 640, 512


def front_end(made):
    """Page, script and style sheet, out of the C++ that cmake/bundle_web.cmake makes."""
    text = Path(made).read_text(encoding="utf-8")
    parts = re.split(r"const std::string_view kServe(\w+) =", text)
    return {name: "".join(re.findall(r'R"panelcal\((.*?)\)panelcal"', body, re.DOTALL))
            for name, body in zip(parts[1::2], parts[2::2])}


def picture(at_px=(320, 256), radius_px=40):
    """A bright disc on grey, as PNG."""
    rows = []
    for y in range(HEIGHT_PX):
        row = bytearray(b"\x00" + bytes([70 + (y * 7) % 11]) * WIDTH_PX)
        if abs(y - at_px[1]) <= radius_px:
            half = int((radius_px ** 2 - (y - at_px[1]) ** 2) ** 0.5)
            row[1 + at_px[0] - half:2 + at_px[0] + half] = b"\xd8" * (2 * half + 1)
        rows.append(bytes(row))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", WIDTH_PX, HEIGHT_PX, 8, 0, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(b"".join(rows)))
            + chunk(b"IEND", b""))


class Station:
    """`state` is the document "screen"; `say` sends it to all screens. `orders` holds the commands that arrived."""

    def __init__(self, made):
        self.files = front_end(made)
        self.changed = threading.Condition()
        self.state, self.frame, self.n_said = {}, 0, 0
        self.picture = picture()
        self.held_by, self.key, self.n_keys = None, "", 0
        self.token, self.is_cut_off = None, False
        self.orders, self.uploads, self.refusal = [], [], None
        self.answers = lambda order: None
        self.server = ThreadingHTTPServer(("127.0.0.1", 0), self.handler())
        self.server.daemon_threads = True
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    @property
    def address(self):
        return f"http://127.0.0.1:{self.server.server_address[1]}/"

    def close(self):
        self.cut_off(True)
        self.server.shutdown()
        self.server.server_close()

    def say(self, state=None, frame=None):
        with self.changed:
            if state is not None:
                self.state = state
            self.frame = frame if frame is not None else self.state.get("view", {}).get("frame", self.frame)
            self.n_said += 1
            self.changed.notify_all()

    def cut_off(self, is_cut_off):
        """No request is answered, and open streams end."""
        with self.changed:
            self.is_cut_off = is_cut_off
            self.n_said += 1
            self.changed.notify_all()

    def handler(station):  # pylint: disable=no-self-argument
        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def log_message(self, *_):
                pass

            def answer(self, code, body, kind="application/json", **headers):
                data = body if isinstance(body, bytes) else (body if isinstance(body, str) else json.dumps(body)).encode()
                self.send_response(code)
                for name, value in {"Content-Type": kind, "Content-Length": len(data), "Cache-Control": "no-store",
                                    "Content-Security-Policy": POLICY, **headers}.items():
                    self.send_header(name.replace("_", "-"), value)
                self.end_headers()
                self.wfile.write(data)

            def is_let_in(self):
                return not station.token or f"token={station.token}" in self.headers.get("Cookie", "")

            def do_GET(self):
                if station.is_cut_off:
                    self.close_connection = True
                    return
                path = urlparse(self.path).path
                kinds = {"/": ("Page", "text/html; charset=utf-8"), "/app.js": ("Script", "text/javascript; charset=utf-8"),
                         "/app.css": ("Style", "text/css; charset=utf-8")}
                if path in kinds:
                    self.answer(200, station.files[kinds[path][0]], kinds[path][1])
                elif not self.is_let_in():
                    self.answer(401, {"error": {"what": "no token"}})
                elif path == "/api/state":
                    self.answer(200, station.state, **({"X_Panelcal_Session": "open"} if station.token else {}))
                elif path == "/api/frame.jpg":
                    self.answer(200, station.picture, "image/png")
                elif path == "/api/events":
                    self.stream()
                else:
                    self.answer(404, {"error": {"what": "no such thing"}})

            def stream(self):
                stream = parse_qs(urlparse(self.path).query).get("stream", [""])[0]
                self.send_response(200)
                self.send_header("Content-Type", "text/event-stream")
                self.send_header("Connection", "close")
                self.end_headers()
                self.close_connection = True
                said = -1
                while True:
                    with station.changed:
                        station.changed.wait_for(lambda: station.n_said != said, timeout=1)  # noqa: B023
                        if station.is_cut_off:
                            return
                        said = station.n_said
                        controls = {"held_by": station.held_by, "mine": bool(stream) and station.key.endswith("." + stream)}
                        events = [("state", station.state), ("controls", {"controls": controls}), ("frame", {"number": station.frame})]
                    try:
                        for name, data in events:
                            self.wfile.write(f"event: {name}\ndata: {json.dumps(data)}\n\n".encode())
                        self.wfile.flush()
                    except OSError:
                        return

            def do_POST(self):
                body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
                if station.is_cut_off:
                    self.close_connection = True
                    return
                path, key = urlparse(self.path).path, self.headers.get("X-Panelcal-Controls")
                if path == "/api/login":
                    good = json.loads(body)["token"] == station.token
                    self.answer(200 if good else 403, {} if good else {"error": {"what": "wrong token"}},
                                **({"Set_Cookie": f"token={station.token}; HttpOnly; SameSite=Strict"} if good else {}))
                elif path == "/api/logout":
                    station.held_by, station.key = None, ""
                    self.answer(200, {}, Set_Cookie="token=; HttpOnly; SameSite=Strict; Max-Age=0")
                elif path == "/api/controls":
                    self.controls(json.loads(body))
                elif not key or key != station.key:
                    self.answer(403, {"error": {"what": "the controls are not yours"}})
                elif path == "/api/programs":
                    station.uploads.append((parse_qs(urlparse(self.path).query)["name"][0], body))
                    self.answer(200, {})
                    station.say()
                elif station.refusal:
                    self.answer(400, {"error": station.refusal})
                else:
                    order = json.loads(body)
                    self.answer(200, {})
                    station.answers(order)
                    # Last: a test that has seen the order says the next state, which no answer may undo.
                    station.orders.append(order)

            def controls(self, asked):
                with station.changed:
                    if asked["take"] and asked.get("from") != station.held_by:
                        self.answer(409, {"error": {"what": f"{station.held_by} has the controls"}})
                        return
                    if asked["take"]:
                        station.n_keys += 1
                        station.held_by, station.key = asked["name"], f"key-{station.n_keys}.stream-{station.n_keys}"
                    else:
                        station.held_by, station.key = None, ""
                    station.n_said += 1
                    station.changed.notify_all()
                self.answer(200, {"key": station.key})

        return Handler
