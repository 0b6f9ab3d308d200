# SPDX-License-Identifier: Apache-2.0
"""A headless Chromium for tests of pages."""
import os
import sys

SKIPPED = 77
DEBIANS_PYTHON = "/usr/bin/python3"

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
except ImportError:
    webdriver = None

WIDTHS_PX = (400, 1280, 2560)


def require():
    """Ends the test as skipped where there is no selenium. Before arguments are taken from sys.argv."""
    if webdriver is not None:
        return
    # Debian's package serves Debian's Python; another one may stand before it in PATH.
    if sys.executable != DEBIANS_PYTHON and os.path.exists(DEBIANS_PYTHON) and "PANELCAL_ANOTHER_PYTHON" not in os.environ:
        os.execve(DEBIANS_PYTHON, [DEBIANS_PYTHON, *sys.argv], {**os.environ, "PANELCAL_ANOTHER_PYTHON": "1"})
    print("python3-selenium is not installed")
    sys.exit(SKIPPED)


def start(language="en", is_dark=False):
    """A browser whose first language is this; to be quit."""
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--lang={language}",
                 "--disable-dev-shm-usage", "--disable-background-networking"):
        options.add_argument(word)
    if is_dark:
        options.add_argument("--force-dark-mode")
    options.add_experimental_option("prefs", {"intl.accept_languages": language})
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)


def show(browser, page, width_px, height_px=900):
    """Opens a file at a width of the window, in CSS pixels."""
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {
        "width": width_px, "height": height_px, "deviceScaleFactor": 1, "mobile": False})
    browser.get(page.resolve().as_uri())
    # Two frames: what is drawn when its size is known has been drawn.
    browser.execute_async_script(
        "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 50)));")


def complaints(browser):
    """Everything that the browser's console has at the level of an error or a warning."""
    return [entry["message"] for entry in browser.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]


def cut_off(browser):
    """Elements that reach out of the page at its left or right, but for those that scroll in themselves."""
    return browser.execute_script("""
      const width = document.documentElement.clientWidth;
      const out = [];
      if (document.documentElement.scrollWidth > width + 1) out.push(`page: ${document.documentElement.scrollWidth}`);
      for (const one of document.querySelectorAll("main *")) {
        const box = one.getBoundingClientRect();
        if (box.width === 0 || one.closest(".scroll") !== null && !one.classList.contains("scroll")) continue;
        if (one.closest("svg") !== null && one.tagName !== "svg") continue;
        if (box.right > width + 1 || box.left < -1) out.push(`${one.tagName}.${one.className}: ${box.left} to ${box.right}`);
      }
      return out;""")
