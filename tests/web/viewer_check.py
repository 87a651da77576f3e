#!/usr/bin/env python3
"""The page of an export in a real browser: its picture against `ldp render`, hands, faults.

  viewer_check.py LDP [-o FOLDER] [--panorama FILE.ldp --views CAMERAS.json]      default: a small room of its own
LDP: the program. FOLDER keeps pictures of what was compared. Of another panorama its first ten views are compared, the
size of its page, what is unfilled within the limits (as what photographs show black seems, too) and how soon it is there.
"""
import argparse
import base64
import http.server
import json
import pathlib
import shutil
import subprocess
import tempfile
import threading
import unittest

import numpy
from PIL import Image

import browser

ROOT = pathlib.Path(__file__).resolve().parents[2]
VIEWS = 10
LEAST_PSNR_DB = 48.0  # 51.6 today
LEAST_ANYWHERE_DB = 38.0  # what a person does not see
OF_ANY_PANORAMA = ["the_page_is_the_file_and_a_small_viewer", "its_pictures_are_those_of_ldp_render",
                   "nothing_is_left_unfilled_anywhere_within_the_limits", "something_is_seen_before_everything_is_there"]
MOST_VIEWER_BYTES = 60_000  # of a page beside 1.4 times its .ldp
LOAD_S = 60
REDUCED_MOTION = ["--force-prefers-reduced-motion"]

PIXELS = """return (async () => {
const pixels = %s;
let text = '';
for (let i = 0; i < pixels.length; i += 8192) text += String.fromCharCode(...pixels.subarray(i, i + 8192));
return btoa(text); })();"""
VIEWER = "document.querySelector('layered-panorama')"
COMPLETE = f"const v = {VIEWER}; return v.complete || (v.frame && v.frame.message.textContent)"


def psnr_db(a, b):
    error = numpy.mean((a.astype(float) - b.astype(float)) ** 2)
    return 99.0 if error == 0 else 10 * numpy.log10(255 ** 2 / error)


def picture(page, expression, width, height, *arguments):
    data = base64.b64decode(page.run(PIXELS % expression, *arguments))
    return numpy.frombuffer(data, numpy.uint8).reshape(height, width, 4)[:, :, :3]


class Room:
    """A panorama (of a small sweep of the project's own scene), its page, views of it by `ldp render`."""

    def __init__(self, program, folder, panorama=None, views=None):
        self.folder = pathlib.Path(folder)
        ldp = lambda *words: subprocess.run([program, *map(str, words)], check=True, stdout=subprocess.DEVNULL)
        self.least_db = LEAST_ANYWHERE_DB if panorama else LEAST_PSNR_DB
        sweep, self.ldp_file, self.page = self.folder / "sweep", self.folder / "room.ldp", self.folder / "room.html"
        if panorama:
            shutil.copy(panorama, self.ldp_file)
        else:
            ldp("scene", "room", "-o", sweep, "--size", "320x240", "--frames", "10", "--arc", "90")
            ldp("build", sweep, "--cameras", sweep / "transforms.json", "-o", self.ldp_file)
        ldp("export", self.ldp_file, "-o", self.page)
        views = json.loads(pathlib.Path(views or sweep / "novel.json").read_text())
        views["frames"] = views["frames"][:VIEWS]
        (self.folder / "views.json").write_text(json.dumps(views))
        ldp("render", self.ldp_file, "--cameras", self.folder / "views.json", "--fill", "background", "-o",
            self.folder / "rendered")
        lens = dict(width=views["w"], height=views["h"], fx=views["fl_x"], fy=views["fl_y"], cx=views["cx"], cy=views["cy"])
        self.cameras = [(pathlib.Path(f["file_path"]).stem, dict(lens, worldFromCamera=f["transform_matrix"]))
                        for f in views["frames"]]

    def rendered(self, name):
        return numpy.asarray(Image.open(self.folder / "rendered" / (name + ".png")).convert("RGB"))


class ViewerCheck(unittest.TestCase):
    room = None
    page = None

    @classmethod
    def setUpClass(cls):
        cls.page = browser.Browser(800, 600, REDUCED_MOTION)

    @classmethod
    def tearDownClass(cls):
        cls.page.__exit__()

    def setUp(self):
        self.open(self.room.page.as_uri())

    def tearDown(self):
        self.assertNotIn("Uncaught", self.page.complaints())

    def open(self, url):
        self.page.open(url)
        self.assertIs(self.page.wait_until(COMPLETE, LOAD_S)[0], True)

    def state(self, name):
        return self.page.run(f"return {VIEWER}.viewpoint.{name}")

    def test_the_page_is_the_file_and_a_small_viewer(self):
        most = 1.4 * self.room.ldp_file.stat().st_size + MOST_VIEWER_BYTES
        self.assertLess(self.room.page.stat().st_size, most)

    def test_its_pictures_are_those_of_ldp_render(self):
        found = []
        for name, camera in self.room.cameras:
            shown = picture(self.page, f"{VIEWER}.pictureOf(arguments[0])", camera["width"], camera["height"], camera)
            Image.fromarray(shown).save(self.room.folder / ("shown_%s.png" % name))
            found.append(psnr_db(shown, self.room.rendered(name)))
        print("against ldp render: %.1f dB at least, %.1f in the mean of %d views" % (min(found), sum(found) / len(found), len(found)))
        self.assertEqual(len(found), VIEWS)
        self.assertGreater(min(found), self.room.least_db)

    def test_nothing_is_left_unfilled_anywhere_within_the_limits(self):
        draw = f"""(() => {{ const v = {VIEWER}, [at, l] = [v.viewpoint, v.viewpoint.limits];
          const [left, right] = l.yaw ?? [at.middle - 2, at.middle + 2];  // of a full turn, thirds
          at.yaw = arguments[0] < 0 ? left : arguments[0] > 0 ? right : at.middle;
          at.out = l.out[arguments[1]]; at.up = l.up[arguments[2]]; at.zoom = 0.7;
          v.scene.draw(at.camera(320, 240)); return v.scene.pixels(); }})()"""
        for yaw in (-1, 0, 1):
            for out in (0, 1):
                for up in (0, 1):
                    shown = picture(self.page, draw, 320, 240, yaw, out, up)
                    Image.fromarray(shown).save(self.room.folder / ("limit_%d_%d_%d.png" % (yaw, out, up)))
                    self.assertEqual(int(numpy.sum(shown.max(axis=2) < 4)), 0, (yaw, out, up))

    def test_something_is_seen_before_everything_is_there(self):
        self.page.run(f"""const v = {VIEWER}, began = performance.now(); window.times = {{}};
          v.addEventListener('preview', () => {{ times.strips ??= v.scene.surfaces.strips.size; times.preview ??= performance.now() - began; }});
          v.addEventListener('load', () => {{ times.load = performance.now() - began; }});
          v.file = v.bytes;""")
        self.page.wait_until("return times.load", LOAD_S)
        times = self.page.run("return times")
        print("something after %.2f s, everything after %.2f s" % (times["preview"] / 1000, times["load"] / 1000))
        self.assertEqual(times["strips"], 1, "the small picture alone")
        self.assertLess(times["preview"], times["load"])
        self.assertGreater(self.page.run(f"return {VIEWER}.scene.surfaces.strips.size"), 1)
        self.assertFalse(self.page.run(f"return {VIEWER}.scene.surfaces.strips.has(-1)"), "and gone in the end")

    def test_hands_turn_move_and_zoom(self):
        before = self.state("yaw")
        drag = [{"type": "pointerMove", "x": 300, "y": 200}, {"type": "pointerDown", "button": 0},
                {"type": "pointerMove", "x": 400, "y": 220, "duration": 50}, {"type": "pointerUp", "button": 0}]
        self.page.act({"type": "pointer", "id": "mouse", "actions": drag})
        self.assertGreater(self.state("yaw"), before)
        pinch = [{"type": "pointer", "id": name, "parameters": {"pointerType": "touch"}, "actions": [
            {"type": "pointerMove", "x": start, "y": 200}, {"type": "pointerDown", "button": 0},
            {"type": "pointerMove", "x": end, "y": 200, "duration": 100}, {"type": "pointerUp", "button": 0}]}
            for name, start, end in (("a", 350, 250), ("b", 450, 550))]
        self.page.act(*pinch)
        self.assertGreater(self.state("zoom"), 1.5)
        self.page.act({"type": "wheel", "id": "wheel", "actions": [
            {"type": "scroll", "x": 300, "y": 200, "deltaX": 0, "deltaY": 400}]})
        self.assertLess(self.state("zoom"), 2.2)

    def test_the_eye_comes_to_rest_within_the_limits(self):
        self.press("w", 3)
        least, most = self.state("limits.out")
        self.assertGreater(self.state("out"), 0)
        self.assertLessEqual(self.state("out"), most)
        self.page.run(f"{VIEWER}.viewpoint.move({{ out: -1000, up: 1000, pitch: 1000 }})")
        self.assertAlmostEqual(self.state("out"), least, places=12)
        self.press("\ue011", 0)
        self.assertEqual(self.state("out"), 0)

    def test_views_are_framed_inside_what_is_seen(self):
        home, turned, most = self.page.run(f"""const at = {VIEWER}.viewpoint, unseen = () => at.look(at.shownZoom).unseen;
          at.camera(390, 844); at.reset(); at.camera(390, 844);
          const home = unseen(); let most = 0;
          for (const by of [{{ yaw: 0.05 }}, {{ yaw: -0.05 }}, {{ pitch: 0.05 }}, {{ pitch: -0.05 }}, {{ out: -0.05 }}, {{ side: 0.05 }}])
            for (let i = 0; i < 60; i++) {{ at.move(by); at.camera(390, 844); most = Math.max(most, unseen()); }}
          return [home, Math.abs(at.yaw - at.middle), most]""")
        self.assertLess(home, 0.01)
        self.assertGreater(turned, 0.01, "it does turn")
        self.assertLess(most, 0.021)

    def test_a_headset_is_shown_each_eyes_picture(self):
        shown = picture(self.page, f"""await (async () => {{ const v = {VIEWER}, gl = v.scene.gl, side = 120;
          const target = gl.createFramebuffer(), texture = gl.createTexture();
          gl.bindTexture(gl.TEXTURE_2D, texture);
          gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, 2 * side, side, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
          gl.bindFramebuffer(gl.FRAMEBUFFER, target);
          gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
          const placed = (x) => ({{ matrix: [1,0,0,0, 0,1,0,0, 0,0,1,0, x,0,0,1] }});
          const projectionMatrix = [1,0,0,0, 0,1,0,0, 0,0,-1,-1, 0,0,0,0];
          const views = [-0.032, 0.032].map((x, i) => ({{ i, projectionMatrix, transform: placed(x) }}));
          let ended; globalThis.XRWebGLLayer = class {{ framebuffer = target; getViewport({{ i }}) {{ return {{ x: i * side, y: 0, width: side, height: side }}; }} }};
          const session = {{ updateRenderState(state) {{ this.renderState = state; }}, requestReferenceSpace: async () => ({{}}),
            addEventListener: (_, call) => {{ ended = call; }}, end: () => ended(), frames: 0,
            requestAnimationFrame(call) {{ if (this.frames++) this.end(); else setTimeout(() => call(0, {{ getViewerPose: () => ({{ transform: placed(0), views }}) }})); }} }};
          Object.defineProperty(navigator, 'xr', {{ value: {{ requestSession: async () => session }}, configurable: true }});
          gl.makeXRCompatible = async () => {{}};
          await v.putOnHeadset();
          const pixels = new Uint8Array(8 * side * side);
          gl.bindFramebuffer(gl.FRAMEBUFFER, target);
          gl.readPixels(0, 0, 2 * side, side, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
          const at = v.viewpoint, [c, s] = [Math.cos(at.yaw), Math.sin(at.yaw)];
          const lens = {{ width: side, height: side, fx: side / 2, fy: side / 2, cx: side / 2, cy: side / 2 }};
          const both = new Uint8Array(16 * side * side);
          both.set(pixels);
          [-0.032, 0.032].forEach((x, i) => {{
            v.scene.draw({{ ...lens, eye: [c * at.unit + s * x, s * at.unit - c * x, 0], axes: [s, -c, 0, 0, 0, -1, c, s, 0] }});
            both.set(v.scene.pixels(), 8 * side * side + 4 * i * side * side); }});
          return both; }})()""", 120, 480)
        in_headset = shown[:240].reshape(120, 240, 3)[::-1]
        for eye in (0, 1):
            expected = shown[240 + 120 * eye:360 + 120 * eye]
            self.assertGreater(psnr_db(in_headset[:, 120 * eye:120 * (eye + 1)], expected), LEAST_PSNR_DB)
        self.assertLess(psnr_db(shown[240:360], shown[360:]), LEAST_PSNR_DB, "the eyes see the same")

    def press(self, key, seconds):
        self.page.run(f"{VIEWER}.frame.canvas.focus()")
        self.page.act({"type": "key", "id": "keys", "actions": [
            {"type": "keyDown", "value": key}, {"type": "pause", "duration": int(1000 * seconds)}, {"type": "keyUp", "value": key}]})

    def test_the_panel_tells_verdict_and_capture(self):
        self.press("i", 0)
        text = self.page.run(f"return {VIEWER}.frame.panel.hidden ? '' : {VIEWER}.frame.panel.textContent")
        self.assertRegex(text, r"(Good|Fair|Sweep again): new views of about \d+ dB")
        self.assertIn("layers", text)

    def test_a_lost_context_is_restored(self):
        name, camera = self.room.cameras[0]
        self.page.run(f"const v = {VIEWER}; window.lose = v.scene.gl.getExtension('WEBGL_lose_context'); lose.loseContext()")
        self.page.wait_until(f"return {VIEWER}.scene === null", LOAD_S)
        self.page.run("lose.restoreContext()")
        self.page.wait_until(f"return {VIEWER}.scene !== null && {VIEWER}.complete", LOAD_S)
        shown = picture(self.page, f"{VIEWER}.pictureOf(arguments[0])", camera["width"], camera["height"], camera)
        self.assertGreater(psnr_db(shown, self.room.rendered(name)), LEAST_PSNR_DB)

    def test_a_damaged_file_is_told_in_words(self):
        self.page.run(f"const v = {VIEWER}, bytes = v.bytes.slice(0); new Uint8Array(bytes)[900] ^= 1; v.file = bytes")
        words, _ = self.page.wait_until(f"return {VIEWER}.frame.message.textContent", LOAD_S)
        self.assertRegex(words, r"^This panorama cannot be shown: chunk \w{4}.*: checksum: expected")

    def test_the_modules_load_a_file_over_http(self):
        class Quiet(http.server.SimpleHTTPRequestHandler):
            def translate_path(self, path):
                return str((ROOT if path.startswith("/web/") else room.folder) / path.lstrip("/"))

            def log_message(self, *_):
                pass

        room = self.room
        (room.folder / "modules.html").write_text("<layered-panorama src='room.ldp' style='height: 300px'></layered-panorama>"
                                                  "<script type='module' src='web/layered_panorama.js'></script>")
        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Quiet) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            try:
                self.open("http://127.0.0.1:%d/modules.html" % server.server_port)
                self.page.run(f"{VIEWER}.setAttribute('src', 'none.ldp')")
                words, _ = self.page.wait_until(f"return {VIEWER}.frame.message.textContent", LOAD_S)
                self.assertRegex(words, "none.ldp cannot be loaded: the server answered 404")
            finally:
                server.shutdown()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ldp", help="the program")
    parser.add_argument("-o", dest="folder", help="keeps pictures of what was compared")
    parser.add_argument("--panorama", metavar="FILE.ldp", help="instead of a small room")
    parser.add_argument("--views", metavar="CAMERAS.json", help="of the panorama, as `ldp render --cameras` takes them")
    arguments = parser.parse_args()
    if bool(arguments.panorama) != bool(arguments.views):
        parser.error("--panorama and --views go together: give the other one, too")
    for file in filter(None, [arguments.ldp, arguments.panorama, arguments.views]):
        if not pathlib.Path(file).is_file():
            parser.error(f"{file}: there is no such file: check the name")
    with tempfile.TemporaryDirectory(prefix="ldp_viewer_") as folder:
        if arguments.folder:
            pathlib.Path(arguments.folder).mkdir(parents=True, exist_ok=True)
        ViewerCheck.room = Room(arguments.ldp, arguments.folder or folder, arguments.panorama, arguments.views)
        checks = unittest.defaultTestLoader.loadTestsFromTestCase(ViewerCheck)
        if arguments.panorama:
            checks = unittest.TestSuite(ViewerCheck("test_" + name) for name in OF_ANY_PANORAMA)
        result = unittest.TextTestRunner(verbosity=2).run(checks)
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    raise SystemExit(main())
