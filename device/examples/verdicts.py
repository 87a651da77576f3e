"""Listens to devices on the network (LCM, channel LDP_RESULT) and shows the verdict on each sweep.

  verdicts.py [ADDRESS:PORT] [COUNT]           default: 239.255.76.67:7667, for ever
Where LCM's Python package is installed `lcm-gen --python messages.lcm` does what `Fields` does here by hand.
"""
import socket
import struct
import sys

VERDICTS = ("not judged", "good", "fair", "sweep again")


class Fields:
    """Reads one field after the other of a message: numbers are big-endian, texts carry their length and end with 0."""

    def __init__(self, data):
        self.data = data

    def number(self, kind):
        value, = struct.unpack_from(">" + kind, self.data)
        self.data = self.data[struct.calcsize(">" + kind):]
        return value

    def text(self):
        length = self.number("i")
        value, self.data = self.data[:length - 1], self.data[length:]
        return value.decode("utf-8", "replace")


def results(address, port):
    """The messages of channel LDP_RESULT, as they come."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as network:
        network.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        network.bind(("", port))
        network.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(address) + bytes(4))
        while True:
            datagram = network.recv(65536)
            channel, _, data = datagram[8:].partition(b"\0")
            if datagram[:4] == b"LC02" and channel == b"LDP_RESULT":
                yield Fields(data[8:])  # after the fingerprint of the type


def main(where="239.255.76.67:7667", count="0"):
    address, port = where.split(":")
    for index, message in enumerate(results(address, int(port)), 1):
        version, _utc_ns, _monotonic_ns, ok = (message.number(kind) for kind in "iqqb")
        capture, file, text = message.text(), message.text(), message.text()
        seconds, verdict, decibels = (message.number(kind) for kind in "dbd")
        reasons = message.text()
        if version == 2:
            print(f"{file if ok else capture}: {VERDICTS[verdict] if ok else 'failed'}, {text}, {seconds:.1f} s", flush=True)
            print(f"  new views of about {decibels:.1f} dB {reasons}" if decibels else f"  {reasons}", flush=True)
        if index == int(count):
            return


if __name__ == "__main__":
    main(*sys.argv[1:])
