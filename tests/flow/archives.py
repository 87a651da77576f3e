#!/usr/bin/env python3
"""archives.py FOLDER PHOTO...   writes .zip files of photos into FOLDER: one sound one, and others that must be refused."""
import os
import sys
import zipfile


def write(folder, name, entries):
    with zipfile.ZipFile(os.path.join(folder, name), "w", zipfile.ZIP_DEFLATED) as archive:
        for entry, content in entries:
            archive.writestr(entry, content)


def changed(folder, name, source, change):
    content = bytearray(open(os.path.join(folder, source), "rb").read())
    open(os.path.join(folder, name), "wb").write(change(content))


def encrypted(content):
    """The flag of every entry, in its local header and in the directory."""
    for mark, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        at = content.find(mark)
        while at >= 0:
            content[at + place] |= 1
            at = content.find(mark, at + 4)
    return content


def main(folder, photos):
    contents = [(os.path.basename(photo), open(photo, "rb").read()) for photo in photos]
    first = contents[0][1]
    hidden = [("__MACOSX/sweep/._a.png", b"of another system"), ("sweep/.hidden.png", b"x"), ("sweep/notes.txt", b"x")]
    notes = [("sweep/capture.json", b'{"fov_degrees": 50}')]
    write(folder, "sound.zip", hidden + [("sweep/" + name, content) for name, content in contents] + notes)
    write(folder, "cut.zip", contents[:3] + [(contents[3][0], contents[3][1][:len(contents[3][1]) // 2])] + contents[4:])
    write(folder, "notes.zip", contents + [("capture.json", b"[]")])
    write(folder, "umlauts.zip", [("\u00fc/\u00e4_" + name, content) for name, content in contents])
    write(folder, "outside.zip", [("../a.png", first)])
    write(folder, "absolute.zip", [("/tmp/a.png", first)])
    write(folder, "two.zip", [("a/a.png", first), ("b/b.png", first)])
    write(folder, "twice.zip", [("a/a.png", first), ("a/a.png", first)])
    write(folder, "none.zip", [("a.txt", b"no photo")])
    write(folder, "bomb.zip", [("a.png", bytes(64 << 20))])
    write(folder, "many.zip", [("%05d.txt" % i, b"") for i in range(20001)])
    changed(folder, "encrypted.zip", "sound.zip", encrypted)
    changed(folder, "short.zip", "sound.zip", lambda content: content[: len(content) // 2])


main(sys.argv[1], sys.argv[2:])
