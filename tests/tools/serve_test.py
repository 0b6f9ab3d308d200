#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""panelcal serve, the real program with a simulated machine: page, state, events, controls, tokens,
TLS, twenty screens, a screen that does not read, the end by a signal, a port in use.

    serve_test.py PANELCAL REPOSITORY
"""
import http.client
import json
import os
import re
import shutil
import signal
import socket
import ssl
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

PANELCAL, REPOSITORY = (str(Path(word).resolve()) for word in sys.argv[1:3])
WAIT_S = 60  # the machine that runs the tests may be busy


class Server:
    """A started server, its address, and what it printed."""

    def __init__(self, folder, *words, address="127.0.0.1:0", host="127.0.0.1"):
        self.process = subprocess.Popen(
            [PANELCAL, "serve", "-m", "machine.toml", "--machine-driver", "sim", "--address", address, *words],
            cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        line = self.process.stdout.readline()
        found = re.match(r"(https?)://[^/]+:(\d+)/", line)
        assert found, (line, self.process.stderr.read())
        self.scheme, self.port, self.host = found.group(1), int(found.group(2)), host
        self.cookie = ""

    def ask(self, method, target, body=None, **headers):
        """(status, headers, body) of one request, as a page of this server sends it."""
        if self.scheme == "https":
            context = ssl._create_unverified_context()  # the certificate is made by this test
            link = http.client.HTTPSConnection(self.host, self.port, timeout=WAIT_S, context=context)
        else:
            link = http.client.HTTPConnection(self.host, self.port, timeout=WAIT_S)
        sent = {"Origin": f"{self.scheme}://{self.host}:{self.port}", "Cookie": self.cookie}
        if isinstance(body, dict):
            body = json.dumps(body)
            sent["Content-Type"] = "application/json"
        sent.update({name.replace("_", "-"): value for name, value in headers.items()})
        link.request(method, target, body, {name: value for name, value in sent.items() if value})
        answer = link.getresponse()
        content = answer.read()
        link.close()
        return answer.status, answer.headers, content

    def take_controls(self, name="Anna"):
        status, _, body = self.ask("POST", "/api/controls", {"name": name, "take": True})
        assert status == 200, body
        return json.loads(body)["key"]

    def end(self, with_signal=signal.SIGTERM):
        """The exit code and what stood on standard error."""
        if self.process.poll() is None:
            self.process.send_signal(with_signal)
        _, errors = self.process.communicate(timeout=WAIT_S)
        return self.process.returncode, errors


class Screen:
    """A stream of events."""

    def __init__(self, server, target="/api/events", reads=True):
        self.socket = socket.create_connection((server.host, server.port), timeout=WAIT_S)
        if not reads:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self.socket.sendall(f"GET {target} HTTP/1.1\r\nHost: {server.host}:{server.port}\r\n"
                            f"Cookie: {server.cookie}\r\n\r\n".encode())
        self.seen = b""

    def wait_for(self, text):
        """False: the stream ended first."""
        while text.encode() not in self.seen:
            piece = self.socket.recv(65536)
            if not piece:
                return False
            self.seen += piece
        return True

    def close(self):
        self.socket.close()


class Serve(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)
        demo = Path(REPOSITORY) / "datasets/demo"
        shutil.copytree(demo, self.folder, dirs_exist_ok=True, ignore=shutil.ignore_patterns("images"))
        self.servers = []
        self.addCleanup(lambda: [server.end(signal.SIGKILL) for server in self.servers])

    def start(self, *words, **options):
        self.servers.append(Server(self.folder, *words, **options))
        return self.servers[-1]

    def refused(self, *words):
        done = subprocess.run([PANELCAL, "serve", "-m", "machine.toml", "--machine-driver", "sim", *words],
                              cwd=self.folder, capture_output=True, text=True, timeout=WAIT_S)
        self.assertEqual(done.returncode, 2, done)
        self.assertEqual(done.stdout, "")
        return done.stderr

    def test_page_state_and_picture(self):
        server = self.start()
        status, headers, page = server.ask("GET", "/")
        self.assertEqual(status, 200)
        self.assertIn(b"app.js", page)
        self.assertIn("script-src 'self'", headers["Content-Security-Policy"])
        self.assertNotIn("unsafe", headers["Content-Security-Policy"])
        self.assertEqual(headers["X-Content-Type-Options"], "nosniff")
        for name in ("/app.js", "/app.css"):
            self.assertEqual(server.ask("GET", name)[0], 200)
        status, _, state = server.ask("GET", "/api/state")
        self.assertEqual((status, json.loads(state)["facts"]), (200, "screen"))
        self.assertEqual(server.ask("GET", "/etc/passwd")[0], 404)
        self.assertEqual(server.ask("GET", "/api/state", Host="evil.example")[0], 403)
        self.assertEqual(server.ask("POST", "/api/command", {"do": "start"}, Origin="http://evil.example")[0], 403)
        code, errors = server.end()
        self.assertEqual((code, errors), (0, ""))

    def test_a_program_is_stored_opened_and_seen_by_all(self):
        server = self.start()
        screens = [Screen(server) for _ in range(2)]
        for screen in screens:
            self.assertTrue(screen.wait_for("event: state"))
        program = (self.folder / "panel.exc").read_bytes()
        upload = {"body": program, "Content_Type": "application/octet-stream"}
        self.assertEqual(server.ask("POST", "/api/programs?name=mine.exc", **upload)[0], 403)
        key = server.take_controls()
        self.assertEqual(server.ask("POST", "/api/controls", {"name": "Ben", "take": True})[0], 409)
        answer = server.ask("POST", "/api/programs?name=mine.exc", X_Panelcal_Controls=key, **upload)
        self.assertEqual(answer[0], 200, answer)
        status, _, body = server.ask("POST", "/api/programs?name=..%2Fmine.exc", X_Panelcal_Controls=key, **upload)
        self.assertEqual(status, 400, body)
        self.assertFalse((self.folder / "jobs/mine.exc").exists())
        command = {"do": "open", "program": "mine.exc"}
        self.assertEqual(server.ask("POST", "/api/command", command)[0], 403)
        answer = server.ask("POST", "/api/command", command, X_Panelcal_Controls=key)
        self.assertEqual(answer[0], 200, answer)
        for screen in screens:
            self.assertTrue(screen.wait_for("mine.exc"))
            self.assertTrue(screen.wait_for('"held_by":"Anna"'))
            screen.close()
        self.assertEqual(server.end()[0], 0)

    def test_twenty_screens_beside_one_that_reads_nothing(self):
        server = self.start()
        stuck = Screen(server, reads=False)
        screens = [Screen(server) for _ in range(20)]
        for screen in screens:
            self.assertTrue(screen.wait_for("event: controls"))
        key = server.take_controls("Clara")
        for screen in screens:
            self.assertTrue(screen.wait_for('"held_by":"Clara"'))
        status, _, _ = server.ask("POST", "/api/controls", {"take": False}, X_Panelcal_Controls=key)
        self.assertEqual(status, 200)
        # A signal ends all streams.
        server.process.send_signal(signal.SIGTERM)
        for screen in screens:
            self.assertFalse(screen.wait_for("never sent"))
            screen.close()
        stuck.close()
        self.assertEqual(server.end()[0], 0)

    def test_a_token_is_made_once_and_asked_for(self):
        server = self.start("--token-file", "token")
        token = re.match(r"token: (\w{25})\n", server.process.stdout.readline()).group(1)
        self.assertEqual(os.stat(self.folder / "token").st_mode & 0o777, 0o600)
        self.assertNotIn(token, (self.folder / "token").read_text())
        self.assertEqual(server.ask("GET", "/api/state")[0], 401)
        self.assertEqual(server.ask("POST", "/api/login", {"token": "guess"})[0], 401)
        status, headers, _ = server.ask("POST", "/api/login", {"token": token})
        self.assertEqual(status, 200)
        self.assertIn("HttpOnly", headers["Set-Cookie"])
        server.cookie = headers["Set-Cookie"].split(";")[0]
        self.assertEqual(server.ask("GET", "/api/state")[0], 200)
        self.assertEqual([server.ask("POST", "/api/login", {"token": "guess"})[0] for _ in range(5)][-1], 429)
        server.end()
        # The next start knows it, and prints none.
        again = self.start("--token-file", "token")
        self.assertEqual(again.ask("POST", "/api/login", {"token": token})[0], 200)
        again.process.send_signal(signal.SIGTERM)
        self.assertEqual(again.process.stdout.read(), "")

    def test_what_is_unsafe_is_refused(self):
        other = ("--address", "0.0.0.0:0")
        self.assertIn("--token-file FILE", self.refused(*other))
        self.assertIn("--plain-http", self.refused(*other, "--token-file", "token"))
        self.assertFalse((self.folder / "token").exists())
        self.assertIn("both of them", self.refused("--certificate", "machine.toml"))
        self.assertIn("error[file-unreadable]",
                      self.refused("--certificate", "machine.toml", "--key", "machine.toml"))
        self.assertIn("error[output-in-use]", self.refused("--token-file", "machine.toml"))

    def test_a_port_in_use_is_named(self):
        server = self.start()
        said = self.refused("--address", f"127.0.0.1:{server.port}")
        self.assertIn(f"127.0.0.1:{server.port}", said)
        self.assertIn("Address already in use", said)
        # And the first one goes on.
        self.assertEqual(server.ask("GET", "/api/state")[0], 200)

    def test_tls(self):
        if shutil.which("openssl") is None:
            self.skipTest("no openssl to make a certificate")
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
                        "-days", "2", "-keyout", "key.pem", "-out", "cert.pem", "-subj", "/CN=drill1"],
                       cwd=self.folder, check=True, capture_output=True)
        server = self.start("--certificate", "cert.pem", "--key", "key.pem")
        self.assertEqual(server.scheme, "https")
        self.assertEqual(server.ask("GET", "/api/state")[0], 200)
        # Plain HTTP to the same port is closed, and does not hold the server up.
        plain = socket.create_connection((server.host, server.port), timeout=WAIT_S)
        plain.sendall(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n")
        try:
            self.assertNotIn(b"200", plain.recv(100))
        except ConnectionResetError:
            pass
        plain.close()
        # Neither does a handshake that never goes on.
        silent = socket.create_connection((server.host, server.port), timeout=WAIT_S)
        self.assertEqual(server.ask("GET", "/")[0], 200)
        old = ssl._create_unverified_context()
        old.maximum_version = ssl.TLSVersion.TLSv1_1
        with self.assertRaises((ssl.SSLError, OSError)):
            with socket.create_connection((server.host, server.port), timeout=WAIT_S) as link:
                old.wrap_socket(link).close()
        silent.close()
        self.assertEqual(server.end()[0], 0)

    def test_two_who_press_start(self):
        """Of many at the same moment one gets the controls."""
        server = self.start()
        taken, barrier = [], threading.Barrier(8)

        def press(name):
            barrier.wait()
            status, _, body = server.ask("POST", "/api/controls", {"name": name, "take": True})
            taken.append((status, body))

        threads = [threading.Thread(target=press, args=(f"P{i}",)) for i in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(sorted(status for status, _ in taken), [200] + [409] * 7)

    def test_it_costs_next_to_nothing_while_nothing_happens(self):
        server = self.start()
        screen = Screen(server)
        self.assertTrue(screen.wait_for("event: state"))
        screen.close()
        time.sleep(1)

        def cpu_s():
            fields = Path(f"/proc/{server.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
            return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        before = cpu_s()
        time.sleep(4)
        # 1 % of 4 s is 40 ms.
        self.assertLess(cpu_s() - before, 0.04 * SLOWNESS)


# Sanitizers cost several times the CPU.
SLOWNESS = float(os.environ.get("PANELCAL_SLOWNESS", "1"))

if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
