#!/usr/bin/python3
"""A USB camera without hardware: speaks USB/IP to the kernel's vhci-hcd, so that the stock uvcvideo driver finds a
UVC 1.0 camera that streams the JPEG files of a folder (MJPEG over a bulk endpoint), byte by byte.

  usb_camera.py FOLDER FPS     until killed; killing it is pulling the plug

The first picture is shown until SIGUSR1 asks for the next, and so on, so that a test waits for what became of each
instead of racing the clock; the last one is shown for ever.
"""
import glob
import select
import signal
import socket
import struct
import sys
import time

CMD_SUBMIT, CMD_UNLINK, RET_SUBMIT, RET_UNLINK = 1, 2, 3, 4
PAYLOAD = 16384  # of one bulk transfer, its 2-byte header included
ECONNRESET = 104
EPIPE = 32


def jpeg_size(data):
    at = 2
    while at < len(data):
        marker, length = data[at + 1], struct.unpack(">H", data[at + 2:at + 4])[0]
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", data[at + 5:at + 9])
            return width, height
        at += 2 + length
    raise SystemExit("not a JPEG")


class Camera:
    def __init__(self, folder, fps):
        self.frames = [open(name, "rb").read() for name in sorted(glob.glob(folder + "/frame_*.jpg"))]
        self.width, self.height = jpeg_size(self.frames[0])
        self.fps = fps
        self.interval = int(1e7 / fps)
        self.streams = False
        self.current, self.sent, self.frame_id = b"", 0, 0
        self.next_frame_at = 0.0
        self.picture = 0
        self.probe = self.probe_control()

    def next_picture(self):
        self.picture = min(self.picture + 1, len(self.frames) - 1)

    # --- descriptors

    def device(self):
        return struct.pack("<BBHBBBBHHHBBBB", 18, 1, 0x0200, 0xEF, 2, 1, 64, 0x1D6B, 0x0102, 1, 0, 1, 0, 1)

    def configuration(self):
        camera = struct.pack("<BBBBHBBHHHB3s", 18, 0x24, 2, 1, 0x0201, 0, 0, 0, 0, 0, 3, b"\0\0\0")
        output = struct.pack("<BBBBHBBB", 9, 0x24, 3, 2, 0x0101, 0, 1, 0)
        header = struct.pack("<BBBHHIBB", 13, 0x24, 1, 0x0100, 13 + len(camera) + len(output), 48000000, 1, 1)
        control = struct.pack("<9B", 9, 4, 0, 0, 0, 0x0E, 1, 0, 0) + header + camera + output
        size = 2 * self.width * self.height
        mjpeg = struct.pack("<11B", 11, 0x24, 6, 1, 1, 1, 1, 0, 0, 0, 0)
        frame = struct.pack("<BBBBBHHIIIIBI", 30, 0x24, 7, 1, 0, self.width, self.height, 1000000, 100000000, size,
                            self.interval, 1, self.interval)
        colour = struct.pack("<6B", 6, 0x24, 0x0D, 1, 1, 4)
        formats = mjpeg + frame + colour
        stream_header = struct.pack("<BBBBHBBBBBBBB", 14, 0x24, 1, 1, 14 + len(formats), 0x81, 0, 2, 0, 0, 0, 1, 0)
        stream = struct.pack("<9B", 9, 4, 1, 0, 1, 0x0E, 2, 0, 0) + stream_header + formats
        endpoint = struct.pack("<BBBBHB", 7, 5, 0x81, 2, 512, 0)
        both = struct.pack("<8B", 8, 0x0B, 0, 2, 0x0E, 3, 0, 0) + control + stream + endpoint
        return struct.pack("<BBHBBBBB", 9, 2, 9 + len(both), 2, 1, 0, 0x80, 250) + both

    def string(self, index):
        if index == 0:
            return struct.pack("<BBH", 4, 3, 0x0409)
        text = "Simulated USB camera".encode("utf-16-le")
        return struct.pack("<BB", 2 + len(text), 3) + text

    def probe_control(self):
        return struct.pack("<HBBIHHHHHII", 1, 1, 1, self.interval, 0, 0, 0, 0, 0, 2 * self.width * self.height, PAYLOAD)

    # --- control requests: the data to answer with, or None to stall

    def control(self, setup, data):
        kind, request, value, index, length = struct.unpack("<BBHHH", setup)
        if kind == 0x80 and request == 6:
            what = value >> 8
            if what == 1:
                return self.device()[:length]
            if what == 2:
                return self.configuration()[:length]
            if what == 3:
                return self.string(value & 255)[:length]
            return None
        if kind == 0x80 and request == 0:
            return b"\0\0"
        if kind in (0x00, 0x01, 0x02):  # address, configuration, interface, features
            return b""
        if kind == 0xA1 and index & 255 == 1 and value >> 8 in (1, 2):
            if request == 0x85:
                return struct.pack("<H", len(self.probe))
            if request == 0x86:
                return b"\x03"
            return self.probe[:length]
        if kind == 0x21 and index & 255 == 1 and value >> 8 in (1, 2):
            if value >> 8 == 2:
                self.streams, self.next_frame_at = True, time.monotonic()
                self.current, self.sent, self.picture = b"", 0, 0
            return b""
        return None

    # --- streaming: the next payload, or None when it is not time yet

    def payload(self, now):
        if self.sent >= len(self.current):
            if now < self.next_frame_at:
                return None
            self.next_frame_at = max(self.next_frame_at + 1 / self.fps, now)
            self.current = self.frames[self.picture]
            self.sent = 0
            self.frame_id ^= 1
        part = self.current[self.sent:self.sent + PAYLOAD - 2]
        self.sent += len(part)
        last = 2 if self.sent >= len(self.current) else 0
        return bytes((2, 0x80 | self.frame_id | last)) + part


class Wire:
    def __init__(self, camera, link):
        self.camera, self.link, self.waiting = camera, link, []

    def read(self, size):
        data = b""
        while len(data) < size:
            part = self.link.recv(size - len(data))
            if not part:
                raise SystemExit("the kernel let go of the camera")
            data += part
        return data

    def answer(self, sequence, status, data, length):
        self.link.sendall(struct.pack(">IIIIIiiiii8x", RET_SUBMIT, sequence, 0, 0, 0, status, length, 0, 0, 0) + data)

    def serve_one(self):
        head = self.read(48)
        command, sequence, _, direction, endpoint = struct.unpack(">5I", head[:20])
        if command == CMD_UNLINK:
            target = struct.unpack(">I", head[20:24])[0]
            found = [urb for urb in self.waiting if urb[0] == target]
            self.waiting = [urb for urb in self.waiting if urb[0] != target]
            status = -ECONNRESET if found else 0
            self.link.sendall(struct.pack(">IIIIIi24x", RET_UNLINK, sequence, 0, 0, 0, status))
            return
        length = struct.unpack(">i", head[24:28])[0]
        data = self.read(length) if direction == 0 and length > 0 else b""
        if endpoint != 0:
            self.waiting.append((sequence, length))
            return
        reply = self.camera.control(head[40:48], data)
        if reply is None:
            self.answer(sequence, -EPIPE, b"", 0)
        else:
            self.answer(sequence, 0, reply, len(reply) if direction == 1 else length)

    def run(self):
        while True:
            now = time.monotonic()
            while self.waiting and self.camera.streams:
                payload = self.camera.payload(now)
                if payload is None:
                    break
                sequence, _ = self.waiting.pop(0)
                self.answer(sequence, 0, payload, len(payload))
            streaming = bool(self.waiting) and self.camera.streams
            wait = max(self.camera.next_frame_at - time.monotonic(), 0) if streaming else None
            if select.select([self.link], [], [], wait)[0]:
                self.serve_one()


def main():
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
    camera = Camera(sys.argv[1], float(sys.argv[2]))
    signal.signal(signal.SIGUSR1, lambda *_: camera.next_picture())
    high_speed, port, device = 3, 0, 0x10002
    with open("/sys/devices/platform/vhci_hcd.0/attach", "w") as attach:
        attach.write(f"{port} {theirs.fileno()} {device} {high_speed}")
    theirs.close()
    Wire(camera, ours).run()


main()
