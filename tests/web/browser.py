# SPDX-License-Identifier: Apache-2.0
"""Pages in a headless Chromium, as a person sees them."""
import json
import shutil
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from facts import MARK  # noqa: E402

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
except ImportError:
    webdriver = None

SKIP = 77
LONGEST_WAIT_S = 120  # the machine that runs the tests may be busy
WIDTHS = (400, 1280, 2560)
HOSTILE = "<img src=x onerror=\"window.injected=1\"><script>window.injected=1</script>&lt;b&gt;'\"</script>\u202e\u0007"
# What turns the direction of writing, and control characters, are shown as their codes.
HOSTILE_SHOWN = HOSTILE.replace("\u202e", "\\u202e").replace("\u0007", "\\u0007")

# Elements that reach over the window's edge (but in what scrolls by itself), and texts of figures that leave them.
CUT_OFF = """
const out = [];
for (const one of document.querySelectorAll("main *")) {
  const box = one.getBoundingClientRect();
  if (box.width && !one.closest(".scroll, svg, pre") && (box.right > innerWidth + 1 || box.left < -1)) {
    out.push(`${one.tagName} ${one.className}: ${one.textContent.slice(0, 40)}`);
  }
}
for (const text of document.querySelectorAll("svg text")) {
  const box = text.getBoundingClientRect(), frame = text.closest("svg").getBoundingClientRect();
  if (box.width && (box.right > frame.right + 1 || box.left < frame.left - 1 || box.bottom > frame.bottom + 1)) {
    out.push(`text in a figure: ${text.textContent}`);
  }
}
return out;
"""


# Calls back when no frame has changed the sizes any more: figures draw themselves anew when they know their width.
STEADY = """
const done = arguments[0];
const sizes = () => JSON.stringify([innerWidth, document.documentElement.scrollHeight,
  ...[...document.querySelectorAll("svg, canvas")].map((one) => [one.clientWidth, one.clientHeight])]);
let before = "", n_same = 0;
const look = () => {
  const now = sizes();
  n_same = now === before ? n_same + 1 : 0;
  before = now;
  if (n_same < 3) requestAnimationFrame(look); else setTimeout(done, 30);
};
requestAnimationFrame(look);
"""

# Texts of facts that stand where the page's own language is spoken.
NOT_ENGLISH = """
const out = [], walk = document.createTreeWalker(document.querySelector("main"), NodeFilter.SHOW_TEXT);
while (walk.nextNode()) {
  const {data, parentElement} = walk.currentNode;
  const said = arguments[0].find((one) => data.includes(one));
  if (said && parentElement.closest("[lang]").lang !== "en") out.push(said);
}
return out;
"""


def sentences(value, keys, is_said=False):
    """The texts of some keys that have several words, wherever they stand in the facts."""
    if isinstance(value, dict):
        return [one for key, part in value.items() for one in sentences(part, keys, key in keys)]
    if isinstance(value, list):
        return [one for part in value for one in sentences(part, keys, is_said)]
    return [value] if is_said and isinstance(value, str) and len(value.split()) > 2 else []


def skip_without_browser():
    """Ends the test where there is no Chromium: a skip, which CI takes for a failure."""
    if webdriver is None or not shutil.which("chromedriver"):
        print("chromium-driver and python3-selenium are not installed")
        sys.exit(SKIP)


class Browser:
    def __init__(self):
        options = webdriver.ChromeOptions()
        # Containers have little shared memory.
        for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--lang=en"):
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        self.driver.set_script_timeout(LONGEST_WAIT_S)

    def close(self):
        self.driver.quit()

    def open(self, path, width=1280, dark=False, quiet=True):
        """Shows a file, or an address; what the console says of it is an error."""
        self.resize(width)
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {
            "features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]})
        self.driver.get(str(path) if str(path).startswith("http:") else Path(path).resolve().as_uri())
        self.settle()
        said = [line["message"] for line in self.driver.get_log("browser")]
        assert not (quiet and said), said

    def forget(self):
        """What a page has kept in this window, and its cookies."""
        if self.driver.current_url.startswith("http:"):
            self.run("sessionStorage.clear()")
        self.driver.delete_all_cookies()

    def resize(self, width):
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
            "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False})
        self.settle()

    def settle(self):
        """Waits until all figures are drawn."""
        self.driver.execute_async_script(STEADY)

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def until(self, condition, *values):
        """Waits until something is true: a function, or an expression in the page of some values."""
        holds = condition if callable(condition) else lambda: self.run(f"return Boolean({condition})", *values)
        end = time.monotonic() + LONGEST_WAIT_S
        while not holds():
            assert time.monotonic() < end, f"{condition}: {self.run('return document.body.innerText')}"
            time.sleep(0.03)

    def texts(self, selector):
        return self.run("return [...document.querySelectorAll(arguments[0])].map((one) => one.textContent)", selector)

    def count(self, selector):
        return len(self.texts(selector))

    def not_marked_as_english(self, facts, keys):
        """Texts of these keys that the page shows outside of what is marked as English."""
        return self.run(NOT_ENGLISH, sentences(facts, keys))

    def cut_off(self):
        self.settle()
        return self.run(CUT_OFF)

    def touch(self, *steps):
        """Fingers that come down at the first step, go through the others and are lifted; a step has a place for each."""
        kinds = ["touchStart"] + ["touchMove"] * (len(steps) - 1) + ["touchEnd"]
        for kind, places in zip(kinds, [*steps, []]):
            self.driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [
                {"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]})
        self.settle()

    def point_at(self, selector, index=0):
        """Moves the pointer to the middle of an element; what the figure then says of it."""
        self.run("""
          const one = document.querySelectorAll(arguments[0])[arguments[1]];
          one.closest("figure").scrollIntoView({block: "center"});
          const box = one.getBoundingClientRect();
          one.closest("svg").dispatchEvent(new PointerEvent("pointermove", {bubbles: true,
            clientX: box.left + box.width / 2, clientY: box.top + box.height / 2}));""", selector, index)
        self.settle()
        return [text for text in self.texts(".hint:not([hidden]) div") if text]


def with_facts(page, facts, path):
    """The same page with other facts."""
    before, rest = Path(page).read_text(encoding="utf-8").split(MARK)
    text = json.dumps(facts).replace("<", "\\u003c")
    Path(path).write_text(before + MARK + text + rest[rest.index("</script>"):], encoding="utf-8")
    return path


def hostile(value, keep=()):
    """The facts with every text replaced but those of the keys that are words of the schema."""
    if isinstance(value, dict):
        return {key: one if key in keep else hostile(one, keep) for key, one in value.items()}
    if isinstance(value, list):
        return [hostile(one, keep) for one in value]
    return HOSTILE if isinstance(value, str) else value
