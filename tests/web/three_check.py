#!/usr/bin/env python3
"""Panoramas in three.js (Debian's libjs-three), as .glb and through the loader of web/three, against the truth beside
`ldp render`; the .glb also through assimp, another program's importer.

  three_check.py LDP [-o FOLDER] [--panorama FILE.ldp --views NOVEL.json]      default: a small room of its own
"""
import argparse
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
from viewer_check import LOAD_S, ROOT, Room, picture, psnr_db

THREE = pathlib.Path("/usr/share/javascript/three")
MOST_LOSS_DB = 1.0  # of the mean over the views, beside ldp render's
UNSEEN = 128  # grey where a view shows nothing

PAGE = """<!DOCTYPE html><meta charset="utf-8">
<script src="/three/three.js"></script><script src="/three/examples/js/loaders/GLTFLoader.js"></script>
<script type="module">
import { LdpReader } from '/web/ldp.js';
import { LdpLoader } from '/web/three/ldp_loader.js';
Object.assign(window, { LdpLoader, LdpReader });
window.renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
renderer.setClearColor(0x808080);
// Colours stay as they are stored: neither decoded nor coded again.
window.show = (object) => {
  window.scene = new THREE.Scene();
  object.traverse(({ material }) => { if (material?.map) material.map.encoding = THREE.LinearEncoding; });
  scene.add(object);
  window.shown = true;
};
// A camera of transforms.json: its lens as three.js takes it, its place in the world of the source cameras.
window.pictureOf = (view, groupFromWorld) => {
  const camera = new THREE.Camera(), { width: w, height: h, fx, fy, cx, cy } = view, [near, far] = [0.05, 2000];
  camera.projectionMatrix.set(2 * fx / w, 0, 1 - 2 * cx / w, 0, 0, 2 * fy / h, 2 * cy / h - 1, 0,
                              0, 0, (far + near) / (near - far), 2 * far * near / (near - far), 0, 0, -1, 0);
  camera.projectionMatrixInverse.getInverse(camera.projectionMatrix);
  camera.matrixAutoUpdate = false;
  camera.matrix.set(...view.worldFromCamera.flat()).premultiply(groupFromWorld);
  camera.updateMatrixWorld(true);
  renderer.setSize(w, h);
  renderer.render(scene, camera);
  const gl = renderer.getContext(), pixels = new Uint8Array(4 * w * h), upright = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  for (let y = 0; y < h; y++) upright.set(pixels.subarray(4 * w * y, 4 * w * (y + 1)), 4 * w * (h - 1 - y));
  return upright;
};
window.ready = true;
</script>"""


def on_grey(file):
    """A view of ldp render: where it shows nothing, grey."""
    rgba = numpy.asarray(Image.open(file).convert("RGBA")).astype(float)
    share = rgba[:, :, 3:] / 255
    return rgba[:, :, :3] * share + UNSEEN * (1 - share)


class Sweep:
    """A panorama, its exports, and views of it whose truth is known."""

    def __init__(self, program, folder, panorama, views):
        self.folder = pathlib.Path(folder)
        self.ldp = lambda *words: subprocess.run([program, *map(str, words)], check=True, stdout=subprocess.DEVNULL)
        self.ldp("export", panorama, "-o", self.folder / "plain.glb", "--plain")
        self.ldp("render", panorama, "--cameras", views, "-o", self.folder / "unfilled")
        shutil.copy(panorama, self.folder / "panorama.ldp")
        (self.folder / "three.html").write_text(PAGE)
        told = json.loads(pathlib.Path(views).read_text())
        lens = dict(width=told["w"], height=told["h"], fx=told["fl_x"], fy=told["fl_y"], cx=told["cx"], cy=told["cy"])
        self.views = []
        for frame in told["frames"]:
            name = pathlib.Path(frame["file_path"])
            true = numpy.asarray(Image.open(pathlib.Path(views).parent / name).convert("RGB")).astype(float)
            self.views.append((name.stem, dict(lens, worldFromCamera=frame["transform_matrix"]), true))


class Files(http.server.SimpleHTTPRequestHandler):
    folder = None

    def translate_path(self, path):
        for prefix, root in (("/web/", ROOT), ("/three/", THREE.parent)):
            if path.startswith(prefix):
                return str(root / path.lstrip("/"))
        return str(self.folder / path.lstrip("/"))

    def log_message(self, *_):
        pass


class ThreeCheck(unittest.TestCase):
    sweep = None

    @classmethod
    def setUpClass(cls):
        handler = type("Served", (Files,), {"folder": cls.sweep.folder})
        cls.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
        threading.Thread(target=cls.server.serve_forever, daemon=True).start()
        cls.page = browser.Browser(800, 600)
        cls.rendered_db = numpy.mean([psnr_db(on_grey(cls.sweep.folder / "unfilled" / (name + ".png")), true)
                                      for name, _, true in cls.sweep.views])

    @classmethod
    def tearDownClass(cls):
        cls.page.__exit__()
        cls.server.shutdown()

    def setUp(self):
        self.page.open("http://127.0.0.1:%d/three.html" % self.server.server_port)
        self.page.wait_until("return window.ready", LOAD_S)

    def shown_db(self, name):
        found = []
        for view, camera, true in self.sweep.views:
            shown = picture(self.page, "pictureOf(arguments[0], groupFromWorld)", camera["width"], camera["height"], camera)
            Image.fromarray(shown).save(self.sweep.folder / ("%s_%s.png" % (name, view)))
            found.append(psnr_db(shown, true))
        found = numpy.mean(found)
        print("%s in three.js %.2f dB, ldp render %.2f dB" % (name, found, self.rendered_db))
        return found

    def test_the_loader_shows_what_ldp_render_shows(self):
        self.page.run("""new LdpLoader(THREE).load('/panorama.ldp').then((group) => {
          window.groupFromWorld = group.userData.groupFromWorld; window.told = group.userData.head.layerCount; return show(group); },
          (error) => { window.shown = error.message; })""")
        self.assertIs(self.page.wait_until("return window.shown", LOAD_S)[0], True)
        self.assertGreater(self.page.run("return told"), 0)
        self.assertGreater(self.shown_db("loader"), self.rendered_db - MOST_LOSS_DB)

    def test_a_glb_shows_what_ldp_render_shows(self):
        self.page.run("""Promise.all([fetch('/panorama.ldp').then((answer) => answer.arrayBuffer()), new Promise((done, failed) =>
            new THREE.GLTFLoader().load('/plain.glb', done, undefined, failed))]).then(([file, glb]) => {
          window.groupFromWorld = new LdpLoader(THREE).groupFromWorld(new LdpReader(file).head);
          show(glb.scene); }).catch((error) => { window.shown = String(error); })""")
        self.assertIs(self.page.wait_until("return window.shown", LOAD_S)[0], True)
        self.assertGreater(self.shown_db("glb"), self.rendered_db - MOST_LOSS_DB)

    def test_what_cannot_be_loaded_is_told(self):
        words = self.page.run("return new LdpLoader(THREE).load('/none.ldp').catch((error) => error.message)")
        self.assertRegex(words, "none.ldp cannot be loaded: the server answered 404")


class OtherImporters(unittest.TestCase):
    sweep = None

    def test_assimp_reads_the_same_mesh(self):
        file = self.sweep.folder / "plain.glb"
        said = subprocess.run(["assimp", "info", file], capture_output=True, text=True).stdout
        words = file.read_bytes()[20:]
        told = json.JSONDecoder().raw_decode(words[:int.from_bytes(file.read_bytes()[12:16], "little")].decode())[0]
        primitives = [p for mesh in told["meshes"] for p in mesh["primitives"]]
        count = lambda index: told["accessors"][index]["count"]
        self.assertRegex(said, r"Meshes:\s+%d\b" % len(primitives))
        self.assertRegex(said, r"Faces:\s+%d\b" % sum(count(p["indices"]) // 3 for p in primitives))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ldp")
    parser.add_argument("-o", dest="folder")
    parser.add_argument("--panorama")
    parser.add_argument("--views")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="ldp_three_") as folder:
        kept = pathlib.Path(arguments.folder or folder)
        kept.mkdir(parents=True, exist_ok=True)
        panorama, views = arguments.panorama, arguments.views
        if panorama is None:
            Room(arguments.ldp, kept)
            panorama, views = kept / "room.ldp", kept / "sweep" / "novel.json"
        ThreeCheck.sweep = OtherImporters.sweep = Sweep(arguments.ldp, kept, panorama, views)
        suite = unittest.TestSuite(map(unittest.defaultTestLoader.loadTestsFromTestCase, (ThreeCheck, OtherImporters)))
        result = unittest.TextTestRunner(verbosity=2).run(suite)
    return 0 if result.wasSuccessful() else 1


if __name__ == "__main__":
    raise SystemExit(main())
