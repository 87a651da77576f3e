#!/usr/bin/env python3
"""The gallery (`ldp serve`) in a real browser: the list, one click to the viewer, a sweep followed live.

  gallery_browser_check.py PROGRAMS [-o FOLDER]      PROGRAMS: the folder of ldp and ldpd. FOLDER keeps screenshots
"""
import argparse
import pathlib
import random
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

import browser

ROOT = pathlib.Path(__file__).resolve().parents[2]
TOKEN = "0123456789abcdef"
SIZES = {"portrait": (500, 844), "landscape": (844, 500), "desktop": (1280, 800)}  # of windows, which are no narrower
SWEEP_S = 300
TEXT = "return document.getElementById('%s').innerText"
BROKEN_PICTURES = "return [...document.images].filter((i) => i.complete && i.naturalWidth === 0 && i.src).map((i) => i.src)"


class GalleryCheck(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.room = tempfile.TemporaryDirectory(prefix="ldp_gallery_")
        cls.top = pathlib.Path(cls.room.name)
        cls.folder = cls.top / "panoramas"
        cls.folder.mkdir()
        shutil.copy(ROOT / "tests/golden/gathered_jpeg.ldp", cls.folder / "room one.ldp")
        (cls.folder / "broken.ldp").write_bytes(b"\xabLDP")
        (cls.top / "token").write_text(TOKEN)
        cls.network = "lcm:udpm://239.255.%d.%d:%d?ttl=0" % tuple(random.Random().randint(*r) for r in ((1, 250), (1, 250), (20000, 30000)))
        cls.server = subprocess.Popen([cls.programs / "ldp", "serve", cls.folder, "--listen", "127.0.0.1:0", "--status", cls.network,
                                       "--token-file", cls.top / "token"], stdout=subprocess.PIPE, text=True)
        cls.url = cls.server.stdout.readline().split()[0]
        cls.page = browser.Browser(1280, 800, ["--force-prefers-reduced-motion"])

    @classmethod
    def tearDownClass(cls):
        cls.page.__exit__()
        cls.server.send_signal(signal.SIGINT)
        cls.server.wait(20)
        cls.server.stdout.close()
        cls.room.cleanup()

    def keep(self, name):
        if self.kept:
            for size, sides in SIZES.items():
                self.page.resize(*sides)
                time.sleep(0.3)
                self.page.screenshot(pathlib.Path(self.kept) / ("%s_%s.png" % (name, size)))
            self.page.resize(*SIZES["desktop"])

    def open_list(self, cards):
        self.page.open(self.url)
        self.page.wait_until("return document.querySelectorAll('.card').length === %d" % cards, 10)

    def test_1_the_list_shows_what_is_there_and_leads_to_the_viewer(self):
        self.open_list(2)
        self.assertIn("damaged", self.page.run(TEXT % "list"))
        self.assertEqual(self.page.run(BROKEN_PICTURES), [])
        self.assertEqual(self.page.run("return document.querySelectorAll('.files button').length"), 0, "deletes without a token")
        self.keep("list")
        self.page.run("document.querySelector('.card > a').click()")
        viewer = "const v = document.querySelector('layered-panorama'); return v && (v.complete || v.frame.message.textContent)"
        self.assertEqual(self.page.wait_until(viewer, 60)[0], True)
        self.assertEqual(self.page.run("return document.title"), "room one.ldp")
        self.keep("viewer")
        self.assertEqual(self.page.complaints(), "")

    def test_2_a_sweep_is_followed_and_stopped_from_the_page(self):
        script = self.top / "script"
        script.write_text("wait 600000")
        configuration = self.top / "ldpd.toml"
        configuration.write_text("camera = 'scene:room?fps=5&width=320&height=240&arc=90'\nbutton = 'script:%s'\nstatus = ['%s']\n"
                                 "output = '%s'\n" % (script, self.network, self.folder))
        self.open_list(2)
        self.page.run("sessionStorage.setItem('ldp-token', '%s')" % TOKEN)
        service = subprocess.Popen([self.programs / "ldpd", "--config", configuration], stderr=subprocess.DEVNULL)
        try:
            self.open_list(2)
            self.page.wait_until((TEXT % "phase") + ".startsWith('Ready')", SWEEP_S)
            self.press("press")
            self.page.wait_until("return document.querySelectorAll('#frames img').length >= 4", SWEEP_S)
            self.assertIn("Taking a sweep", self.page.run(TEXT % "phase"))
            self.assertRegex(self.page.run(TEXT % "figures"), r"\d+° · \d+ photographs")
            self.assertEqual(self.page.run(BROKEN_PICTURES), [])
            self.keep("sweep")
            self.press("stop")
            self.page.wait_until((TEXT % "phase") + ".startsWith('Making')", SWEEP_S)
            self.page.wait_until("return document.querySelectorAll('.card').length === 3", SWEEP_S)
            self.assertIn("sweep_000001", self.page.run("return document.querySelector('.card').innerText"), "the newest is first")
            self.keep("done")
        finally:
            service.terminate()
            service.wait(20)
        self.page.run("globalThis.confirm = () => true; document.querySelector('.card .files button').click()")
        self.page.wait_until("return document.querySelectorAll('.card').length === 2", 10)
        self.assertFalse((self.folder / "sweep_000001").exists())
        self.assertEqual(self.page.complaints(), "")

    def press(self, word):
        self.page.run("document.querySelector('#hands [data-word=%s]').click()" % word)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("-o", dest="kept")
    arguments = parser.parse_args()
    GalleryCheck.programs, GalleryCheck.kept = arguments.programs, arguments.kept
    unittest.main(argv=["gallery_browser_check"], verbosity=2)
