"""Debian's chromium, headless and with software graphics, driven through chromedriver (WebDriver over HTTP)."""
import base64
import json
import shutil
import subprocess
import tempfile
import time
import urllib.error
import urllib.request

FLAGS = ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader",
         "--enable-unsafe-swiftshader", "--hide-scrollbars", "--no-first-run", "--disable-extensions"]
START_S = 30


def missing():
    """Why no browser can be started; None where one can."""
    for program in ("chromium", "chromedriver"):
        if shutil.which(program) is None:
            return program + " is not installed"
    return None


class Browser:
    """With-block: a browser with one page."""

    def __init__(self, width=800, height=600, extra=()):
        self.profile = tempfile.mkdtemp(prefix="ldp_chromium_")
        self.driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.session = None
        self.url = "http://127.0.0.1:%d" % self._port()
        options = dict(args=FLAGS + ["--window-size=%d,%d" % (width, height), "--user-data-dir=" + self.profile, *extra])
        wanted = {"browserName": "chrome", "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"},
                  "timeouts": {"script": 120000}}
        self.session = self._call("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})["sessionId"]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.session:
            self._call("DELETE", "/session/" + self.session)
        self.driver.terminate()
        self.driver.wait()
        shutil.rmtree(self.profile, ignore_errors=True)

    def _port(self):
        end = time.monotonic() + START_S
        for line in self.driver.stdout:
            if "started successfully on port" in line:
                return int(line.rstrip().rstrip(".").split()[-1])
            if time.monotonic() > end:
                break
        raise RuntimeError("chromedriver did not start")

    def _call(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.url + path, data, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.urlopen(request, timeout=180) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(json.load(error)["value"]["message"]) from None

    def _of_session(self, method, path, body=None):
        return self._call(method, "/session/" + self.session + path, body)

    def open(self, url):
        self._of_session("POST", "/url", {"url": url})

    def run(self, script, *arguments):
        """A function body; what it returns (or promises) as JSON."""
        return self._of_session("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def wait_until(self, script, seconds):
        """Until a function body returns something true: that, and the seconds it took."""
        began = time.monotonic()
        while time.monotonic() - began < seconds:
            value = self.run(script)
            if value:
                return value, time.monotonic() - began
            time.sleep(0.05)
        raise RuntimeError("not within %s s: %s\n%s" % (seconds, script, self.complaints()))

    def act(self, *sources):
        """WebDriver actions: pointers and keys."""
        self._of_session("POST", "/actions", {"actions": list(sources)})
        self._of_session("DELETE", "/actions")

    def resize(self, width, height):
        self._of_session("POST", "/window/rect", {"width": width, "height": height})

    def screenshot(self, path):
        with open(path, "wb") as file:
            file.write(base64.b64decode(self._of_session("GET", "/screenshot")))

    def complaints(self):
        """What pages wrote on the console."""
        return "\n".join(entry["message"] for entry in self._of_session("POST", "/se/log", {"type": "browser"}))
