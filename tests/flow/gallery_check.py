#!/usr/bin/env python3
"""The gallery (`ldp serve`) from outside: hostile and slow clients, many at once, ranges, ETags, changes by token.

  gallery_check.py LDP PANORAMA.ldp
"""
import asyncio
import gzip
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

LDP, PANORAMA = sys.argv[1:3] if len(sys.argv) > 2 else (None, None)
SANITIZED = bool(os.environ.get("LDP_SANITIZED"))  # what is freed stays for a while
SECRET = b"nobody may read this"
TOKEN = "a token that only this test knows"
CLIENTS, REQUESTS = 200, 10_000
MOST_GROWTH_KB = 8_000


class Server:
    """A gallery on a free port of this machine."""

    def __init__(self, folder, *options, command=None):
        words = command or [LDP, "serve", str(folder), "--listen", "127.0.0.1:0", *map(str, options)]
        self.process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, pass_fds=getattr(command, "fds", ()))
        self.port = int(self.process.stdout.readline().split("/")[2].rsplit(":", 1)[1])

    def stop(self):
        self.process.send_signal(signal.SIGINT)
        self.process.stdout.close()
        return self.process.wait(20)

    def connect(self, timeout=10):
        return socket.create_connection(("127.0.0.1", self.port), timeout)

    def raw(self, request):
        """What comes back until the server closes; nothing for a connection that it just ends."""
        with self.connect() as client:
            answer = b""
            try:
                client.sendall(request)
                client.shutdown(socket.SHUT_WR)
                while part := client.recv(65536):
                    answer += part
            except OSError:
                pass
            return answer

    def ask(self, path, method="GET", **headers):
        """(status, headers, body)"""
        lines = "".join("%s: %s\r\n" % (name.replace("_", "-"), value) for name, value in headers.items())
        answer = self.raw(("%s %s HTTP/1.1\r\nHost: x\r\nConnection: close\r\n%s\r\n" % (method, path, lines)).encode())
        head, body = answer.split(b"\r\n\r\n", 1)
        first, *rest = head.decode().split("\r\n")
        return int(first.split()[1]), dict(line.split(": ", 1) for line in rest), body

    def kilobytes(self):
        text = pathlib.Path("/proc/%d/status" % self.process.pid).read_text()
        return int(next(line for line in text.splitlines() if line.startswith("VmRSS")).split()[1])

    def descriptors(self):
        return len(os.listdir("/proc/%d/fd" % self.process.pid))


def make_folder(top):
    """DIR with what is to be seen, and every kind of way out of it."""
    outside, folder = top / "outside", top / "panoramas"
    for new in (outside, folder, folder / "sweep_000001", folder / "inner"):
        new.mkdir()
    for name in ("secret.ldp", "frame_000.jpg", "capture.json"):
        (outside / name).write_bytes(SECRET)
    (folder / "notes.txt").write_bytes(SECRET)
    (folder / ".hidden.ldp").write_bytes(SECRET)
    (folder / "inner" / "deep.ldp").write_bytes(SECRET)
    (folder / "sweep_000001" / "capture.json").write_bytes(SECRET)
    (folder / "sweep_000001" / "frame_000.jpg").write_bytes(b"a frame")
    (folder / "sweep_000001" / "frame_001.jpg").symlink_to(outside / "frame_000.jpg")
    (folder / "sweep_000002").symlink_to(outside)
    (folder / "link.ldp").symlink_to(outside / "secret.ldp")
    (folder / "folder.ldp").mkdir()
    os.mkfifo(folder / "pipe.ldp")
    shutil.copy(PANORAMA, folder / "room.ldp")
    shutil.copy(PANORAMA, folder / "sweep_000001.ldp")
    (folder / "broken.ldp").write_bytes(pathlib.Path(PANORAMA).read_bytes()[:100])
    with open(folder / "large.ldp", "wb") as file:
        file.truncate(64 << 20)
    return folder


HOSTILE_PATHS = [
    "/panoramas/../outside/secret.ldp", "/panoramas/..%2foutside%2fsecret.ldp", "/panoramas/%2e%2e/outside/secret.ldp",
    "/panoramas/..%5coutside%5csecret.ldp", "/panoramas/....//outside/secret.ldp", "/panoramas//etc/passwd",
    "/panoramas/%2fetc%2fpasswd", "/panoramas/link.ldp", "/panoramas/link.jpg", "/panoramas/folder.ldp", "/panoramas/pipe.ldp",
    "/panoramas/.hidden.ldp", "/panoramas/notes.txt", "/panoramas/inner/deep.ldp", "/panoramas/inner%2fdeep.ldp",
    "/panoramas/room.ldp%00.txt", "/panoramas/room.ldp%00", "/panoramas/room.ldp/", "/panoramas/.", "/panoramas/..",
    "/panoramas/", "/panoramas", "/panoramas/" + "a" * 5000 + ".ldp", "/panoramas/%ff%fe.ldp", "/panoramas/%zz.ldp",
    "/panoramas/%u002e%u002e/x.ldp", "/thumbnails/link.ldp", "/thumbnails/../room.ldp", "/thumbnails/notes.txt",
    "/view/link.ldp", "/view/%3cscript%3e.ldp", "/sweeps/sweep_000001/frame_001.jpg", "/sweeps/sweep_000002/frame_000.jpg",
    "/sweeps/sweep_000001/capture.json", "/sweeps/sweep_000001/../room.ldp", "/sweeps/../room.ldp/frame_000.jpg",
    "/sweeps/sweep_000001/frame_000.jpg/../capture.json", "/sweeps/inner/deep.ldp", "/sweeps/.", "/sweeps/",
    "/etc/passwd", "/../../etc/passwd", "//etc/passwd", "/proc/self/environ", "/panoramas.json/..", "*", "http://x/etc/passwd",
]
HOSTILE_REQUESTS = [
    b"\r\n\r\n", b"GET\r\n\r\n", b"GET /\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"\x00\x01\x02\x03\r\n\r\n", b"\x16\x03\x01\x02\x00\r\n\r\n",
    b"TRACE / HTTP/1.1\r\nHost: x\r\n\r\n", b"CONNECT x:80 HTTP/1.1\r\n\r\n", b"PUT /panoramas/x.ldp HTTP/1.1\r\nContent-Length: 3\r\n\r\nabc",
    b"POST /device/press HTTP/1.1\r\nContent-Length: 0\r\n\r\n", b"DELETE /panoramas/room.ldp HTTP/1.1\r\n\r\n",
    b"POST /device/press HTTP/1.1\r\nAuthorization: Bearer \r\n\r\n", b"DELETE /panoramas/room.ldp HTTP/1.1\r\nAuthorization: Bearer x\r\n\r\n",
    b"PATCH /panoramas/room.ldp HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\r\nX: " + b"a" * 9000 + b"\r\n\r\n",
    b"GET / HTTP/1.1\r\n" + b"".join(b"X-%d: y\r\n" % i for i in range(5000)) + b"\r\n", b"GET / HTTP/1.1\r\n" + b"X" * 100_000,
    b"GET /" + b"a" * 20_000 + b" HTTP/1.1\r\n\r\n", b"A" * 1_000_000,
]


class Hostile(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.top = tempfile.TemporaryDirectory(prefix="ldp_gallery_")
        cls.server = Server(make_folder(pathlib.Path(cls.top.name)))

    @classmethod
    def tearDownClass(cls):
        status = cls.server.stop()
        cls.top.cleanup()
        assert status == 130, "it ended with status %d" % status

    def test_nothing_outside_the_folder_is_ever_read(self):
        for path in HOSTILE_PATHS:
            with self.subTest(path):
                answer = self.server.raw(("GET %s HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n" % path).encode())
                self.assertNotIn(SECRET, answer)
                self.assertNotIn(b"root:", answer)
                self.assertRegex(answer.split(b"\r\n")[0], rb"^HTTP/1.1 (400|404|414) ")

    def test_what_is_no_good_request_is_refused(self):
        for request in HOSTILE_REQUESTS:
            with self.subTest(request[:60]):
                answer = self.server.raw(request)
                self.assertRegex(answer.split(b"\r\n")[0] or b"closed", rb"^(closed|HTTP/1.[01] (400|401|403|404|405|414|431) )")
        self.assertEqual(self.server.ask("/panoramas/room.ldp")[0], 200)

    def test_a_body_that_nobody_asked_for_is_no_second_request(self):
        hidden = b"GET /panoramas/room.ldp HTTP/1.1\r\nHost: x\r\n\r\n"
        answer = self.server.raw(b"POST /x HTTP/1.1\r\nHost: x\r\nContent-Length: %d\r\n\r\n%s" % (len(hidden), hidden))
        self.assertEqual(answer.count(b"HTTP/1.1 "), 1)

    def test_ranges(self):
        whole = pathlib.Path(PANORAMA).read_bytes()
        for header, status, part in [("bytes=0-3", 206, whole[:4]), ("bytes=-5", 206, whole[-5:]), ("bytes=10-", 206, whole[10:]),
                                     ("bytes=0-99999999999", 206, whole), ("bytes=%d-" % len(whole), 416, None),
                                     ("bytes=0-0,2-2", 200, whole), ("bytes=-0", 416, None),
                                     ("bytes=18446744073709551616-", 416, None)]:
            with self.subTest(header):
                got, headers, body = self.server.ask("/panoramas/room.ldp", Range=header)
                self.assertEqual(got, status)
                if part is not None:
                    self.assertEqual(body, part)
                if status == 206:
                    self.assertEqual(headers["Content-Range"].split("/")[1], str(len(whole)))
        many = "bytes=" + ",".join("0-" for _ in range(2000))
        self.assertLessEqual(len(self.server.ask("/panoramas/room.ldp", Range=many)[2]), len(whole))

    def test_what_is_known_is_not_sent_again(self):
        for path in ("/", "/viewer.js", "/panoramas.json", "/panoramas/room.ldp", "/panoramas/room.jpg", "/thumbnails/room.ldp"):
            with self.subTest(path):
                status, headers, body = self.server.ask(path)
                self.assertEqual(status, 200)
                again, _, nothing = self.server.ask(path, If_None_Match=headers["ETag"])
                self.assertEqual((again, nothing), (304, b""))
                self.assertEqual(self.server.ask(path, method="HEAD")[2], b"")
        etag = self.server.ask("/panoramas/room.ldp")[1]["ETag"]
        self.assertEqual(self.server.ask("/panoramas/room.ldp", Range="bytes=0-3", If_Range=etag)[0], 206)
        self.assertEqual(self.server.ask("/panoramas/room.ldp", Range="bytes=0-3", If_Range='"other"')[0], 200)

    def test_scripts_come_compressed_to_who_can_read_them(self):
        plain, packed = self.server.ask("/viewer.js"), self.server.ask("/viewer.js", Accept_Encoding="gzip")
        self.assertEqual(packed[1]["Content-Encoding"], "gzip")
        self.assertNotIn("Content-Encoding", plain[1])
        self.assertEqual(gzip.decompress(packed[2]), plain[2])
        self.assertLess(len(packed[2]), len(plain[2]) / 2)

    def test_the_list_tells_what_is_there(self):
        told = {p["name"]: p for p in json.loads(self.server.ask("/panoramas.json")[2])["panoramas"]}
        self.assertEqual(set(told), {"room.ldp", "sweep_000001.ldp", "broken.ldp", "large.ldp"})
        self.assertGreater(told["room.ldp"]["layers"], 0)
        self.assertIn("expected", told["broken.ldp"]["trouble"])
        self.assertEqual(self.server.ask("/panoramas/broken.glb")[0], 500)
        self.assertEqual(self.server.ask("/panoramas/room.glb")[2][:4], b"glTF")
        self.assertEqual(self.server.ask("/sweeps/sweep_000001/frame_000.jpg")[2], b"a frame")

    def test_two_hundred_clients_at_once_and_memory_stays_flat(self):
        paths = ["/", "/panoramas.json", "/panoramas/room.ldp", "/thumbnails/room.ldp", "/viewer.js", "/worker.js"]
        self.run_clients(paths, 2_000)
        kilobytes, descriptors = self.server.kilobytes(), self.server.descriptors()
        began = time.monotonic()
        self.run_clients(paths, REQUESTS)
        seconds = time.monotonic() - began
        time.sleep(0.3)
        growth = self.server.kilobytes() - kilobytes
        print("\n%d clients, %d requests in %.1f s; %d kB resident, %+d kB by them" % (CLIENTS, REQUESTS, seconds, kilobytes, growth))
        if not SANITIZED:
            self.assertLess(growth, MOST_GROWTH_KB)
        self.assertLess(self.server.descriptors(), descriptors + 20)

    def run_clients(self, paths, requests):
        expected = {path: len(self.server.ask(path)[2]) for path in paths}

        async def client(number):
            reader, writer = await asyncio.open_connection("127.0.0.1", self.server.port)
            for i in range(requests // CLIENTS):
                path = paths[(number + i) % len(paths)]
                writer.write(("GET %s HTTP/1.1\r\nHost: x\r\n\r\n" % path).encode())
                head = (await reader.readuntil(b"\r\n\r\n")).decode()
                length = int(head.split("Content-Length: ")[1].split("\r\n")[0])
                self.assertTrue(head.startswith("HTTP/1.1 200 "), head)
                self.assertEqual(len(await reader.readexactly(length)), expected[path])
            writer.close()

        async def all_of_them():
            await asyncio.gather(*(client(i) for i in range(CLIENTS)))

        asyncio.run(all_of_them())

    def test_slow_clients_keep_nobody_waiting(self):
        slow = [self.server.connect() for _ in range(300)]
        for client in slow:
            client.sendall(b"GET / HTTP/1.1\r\nX: ")
        for _ in range(3):
            began = time.monotonic()
            self.assertEqual(self.server.ask("/panoramas/room.ldp")[0], 200)
            self.assertLess(time.monotonic() - began, 1)
            for client in slow:
                client.sendall(b"a")
        self.assertEqual(self.ends_of(slow, seconds=15), len(slow))

    def test_clients_that_read_nothing_are_let_go(self):
        slow = [self.server.connect() for _ in range(8)]
        for client in slow:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            client.sendall(b"GET /panoramas/large.ldp HTTP/1.1\r\nHost: x\r\n\r\n")
        began = time.monotonic()
        self.assertEqual(self.server.ask("/panoramas/room.ldp")[0], 200)
        self.assertLess(time.monotonic() - began, 1)
        before = self.server.descriptors()
        end = time.monotonic() + 60
        while self.server.descriptors() > before - len(slow) and time.monotonic() < end:
            time.sleep(0.1)
        self.assertLessEqual(self.server.descriptors(), before - len(slow))
        for client in slow:
            client.close()

    def ends_of(self, clients, seconds):
        """How many of them the server has ended by then."""
        end, ended = time.monotonic() + seconds, 0
        for client in clients:
            client.settimeout(max(0.01, end - time.monotonic()))
            try:
                while client.recv(65536):
                    pass
                ended += 1
            except ConnectionResetError:
                ended += 1
            except socket.timeout:
                pass
            client.close()
        return ended


class Changes(unittest.TestCase):
    def setUp(self):
        self.top = tempfile.TemporaryDirectory(prefix="ldp_gallery_")
        self.folder = make_folder(pathlib.Path(self.top.name))
        token = pathlib.Path(self.top.name) / "token"
        token.write_text(TOKEN + "\n")
        self.server = Server(self.folder, "--token-file", token)

    def tearDown(self):
        self.server.stop()
        self.top.cleanup()

    def test_the_token_lets_delete_and_nothing_else_does(self):
        for header in ({}, {"Authorization": "Bearer " + TOKEN[:-1]}, {"Authorization": "Bearer " + TOKEN + "x"},
                       {"Authorization": "Basic " + TOKEN}, {"Authorization": TOKEN}):
            self.assertEqual(self.server.ask("/panoramas/room.ldp", "DELETE", **header)[0], 401)
        good = {"Authorization": "Bearer " + TOKEN}
        self.assertTrue((self.folder / "room.ldp").exists())
        for name in ("link.ldp", "notes.txt", "..%2foutside%2fsecret.ldp", "folder.ldp", "none.ldp"):
            self.assertEqual(self.server.ask("/panoramas/" + name, "DELETE", **good)[0], 404, name)
        self.assertEqual(self.server.ask("/panoramas/room.ldp", "DELETE", **good)[0], 204)
        self.assertFalse((self.folder / "room.ldp").exists())
        self.assertEqual(self.server.ask("/panoramas/sweep_000001.ldp", "DELETE", **good)[0], 204)
        self.assertFalse((self.folder / "sweep_000001").exists(), "its sweep would be built again")
        self.assertTrue((self.folder.parent / "outside" / "frame_000.jpg").exists())
        self.assertEqual(self.server.ask("/device/press", "POST", **good)[0], 503)


class Start(unittest.TestCase):
    def test_a_socket_that_is_handed_over_is_served(self):
        with tempfile.TemporaryDirectory() as folder, socket.create_server(("127.0.0.1", 0)) as listening:
            class Words(list):
                fds = (listening.fileno(),)
            script = 'LISTEN_PID=$$ LISTEN_FDS=1 exec "$0" serve "$1" 3<&%d' % listening.fileno()
            server = Server(folder, command=Words(["sh", "-c", script, LDP, folder]))
            self.assertEqual(server.port, listening.getsockname()[1])
            self.assertEqual(json.loads(server.ask("/panoramas.json")[2])["panoramas"], [])
            self.assertEqual(server.stop(), 130)

    def test_the_token_may_come_through_a_pipe(self):
        with tempfile.TemporaryDirectory() as folder:
            script = 'exec "$0" serve "$1" --listen 127.0.0.1:0 --token-file <(echo "$2")'
            server = Server(folder, command=["bash", "-c", script, LDP, folder, TOKEN])
            self.assertEqual(server.ask("/panoramas.json")[0], 200)
            self.assertEqual(server.stop(), 130)

    def test_what_cannot_be_meant_is_refused_in_words(self):
        with tempfile.TemporaryDirectory() as folder:
            short = pathlib.Path(folder) / "token"
            short.write_text("short\n")
            for words, said in [(["/nonexistent"], "cannot open the folder /nonexistent: No such file or directory: give the folder"), ([folder, "--listen", "nonsense"], "is no address"),
                                *[([folder, "--listen", port], "is no address to listen on: HOST:PORT") for port in (":70000", ":-1", ":http", ":80x", ":")],
                                ([folder, "--listen", "192.0.2.1:80"], "cannot listen on"), ([folder, "--token-file", short], "16 characters"),
                                ([folder, "--token-file", folder + "/missing"], "missing: there is no such file")]:
                done = subprocess.run([LDP, "serve", *map(str, words)], capture_output=True, text=True, timeout=20)
                self.assertNotEqual(done.returncode, 0)
                self.assertIn(said, done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
