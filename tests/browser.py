# SPDX-License-Identifier: Apache-2.0
"""A real browser for tests: Debian's Chromium without a screen, driven by Playwright."""

import re
import shutil
import socket
import subprocess
import sys
import time
from contextlib import contextmanager

from playwright.sync_api import sync_playwright

# No connection to anywhere but the page; drawing without a graphics card.
FLAGS = [
    "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-sync",
    "--disable-component-update", "--disable-quic", "--enable-unsafe-swiftshader",
    "--disable-gpu-watchdog",  # drawing is slow here; it does not hang
]  # fmt: skip
# Nothing here takes a tenth of it on an idle machine [s].
PATIENCE = 600.0


@contextmanager
def studio(*arguments):
    """Run `spiral-gripper studio` with these arguments; give the page's address."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    code = "from spiral_gripper.cli.main import main; main()"
    command = [sys.executable, "-c", code, "studio", "--no-browser", "--port", str(port)]
    with subprocess.Popen([*command, *arguments], stdout=subprocess.PIPE, text=True) as process:
        try:
            any("Ctrl-C" in line for line in process.stdout)
            yield f"http://127.0.0.1:{port}"
        finally:  # also after a failure: leaving the block waits for the process
            process.terminate()


@contextmanager
def opened(address):
    """Open a page; what it complains about on its console fails the test."""
    names = ("chromium", "chromium-browser", "google-chrome")
    path = next(filter(None, map(shutil.which, names)), None)
    assert path, "this test needs Chromium: apt-get install chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=path, args=FLAGS, timeout=1e3 * PATIENCE
        )
        page = browser.new_page(viewport={"width": 1400, "height": 1000})
        page.set_default_timeout(1e3 * PATIENCE)
        complaints = []
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("console", lambda said: said.type != "error" or complaints.append(said.text))
        page.goto(address)
        yield page
        assert not complaints, complaints
        browser.close()


def appears(page, pattern):
    """Wait until a text is on the page; return it."""
    found = page.get_by_text(re.compile(pattern)).first
    found.wait_for()
    return found.inner_text()


def wait_until(condition):
    """Wait until a condition holds; the last look decides."""
    end = time.monotonic() + PATIENCE
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)
    assert condition()
