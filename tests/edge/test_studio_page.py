# SPDX-License-Identifier: Apache-2.0
"""The studio in a real browser: Debian's Chromium without a screen, driven by Playwright."""

import os
import re
import shutil
import socket
import subprocess
import sys
import time

import pytest
from playwright.sync_api import sync_playwright

pytestmark = pytest.mark.slow

# No connection to anywhere but the page; drawing without a graphics card.
FLAGS = [
    "--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-sync",
    "--disable-component-update", "--disable-quic", "--enable-unsafe-swiftshader",
]  # fmt: skip
PATIENCE = 60_000  # [ms]


@pytest.fixture(scope="module")
def address():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    code = "from spiral_gripper.cli.main import main; main()"
    command = [sys.executable, "-c", code, "studio", "--no-browser", "--port", str(port)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as studio:
        for line in studio.stdout:
            if "Ctrl-C" in line:
                break
        yield f"http://127.0.0.1:{port}"
        studio.terminate()


@pytest.fixture
def page(address):
    names = ("chromium", "chromium-browser", "google-chrome")
    browser_path = next(filter(None, map(shutil.which, names)), None)
    assert browser_path, "this test needs Chromium: apt-get install chromium"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path, args=FLAGS)
        page = browser.new_page(viewport={"width": 1400, "height": 1000})
        page.complaints = []
        page.on("pageerror", lambda error: page.complaints.append(str(error)))
        page.on(
            "console",
            lambda said: page.complaints.append(said.text) if said.type == "error" else None,
        )
        page.goto(address)
        page.get_by_text("perfect wrap of").wait_for(timeout=PATIENCE)
        yield page
        assert page.complaints == []
        browser.close()


def tip(page):
    """Return the tip's position that the page states [mm]."""
    text = page.get_by_text(re.compile("tip of the free coil at")).inner_text()
    return tuple(float(number) for number in re.findall(r"-?\d+\.\d", text))


def wait_until(condition):
    """Wait until a condition holds; the last look decides."""
    end = time.monotonic() + PATIENCE / 1e3
    while not condition() and time.monotonic() < end:
        time.sleep(0.05)
    assert condition()


def test_a_pressure_moves_the_gripper_and_its_picture(page):
    before, picture = tip(page), page.locator("canvas").first.screenshot()
    page.get_by_text("Set the wrap pressure").click()
    wait_until(lambda: tip(page) != before)
    wait_until(lambda: page.get_by_text("perfect wrap", exact=True).is_visible())
    wait_until(lambda: page.locator("canvas").first.screenshot() != picture)


def test_the_approach_plays_from_nothing_to_the_wrap(page):
    page.get_by_text("Play the approach").click()
    seen = set()
    wait_until(lambda: seen.add(tip(page)) or len(seen) > 2)
    wait_until(lambda: page.get_by_text("perfect wrap", exact=True).is_visible())


SUFFIXES = {"spheres": "model.yaml", "gripper file": "yaml"}


@pytest.mark.parametrize(
    "kind", ["csv", "stl", "glb", "urdf", "spheres", "gripper file", "html", "png"]
)
def test_an_export_arrives(page, kind, tmp_path):
    with page.expect_download(timeout=PATIENCE) as download:
        page.get_by_text(kind, exact=True).click()
    assert download.value.suggested_filename == f"paper_design_70.{SUFFIXES.get(kind, kind)}"
    path = tmp_path / kind
    download.value.save_as(path)
    assert path.stat().st_size > 1000


def test_contact_and_holding_force_come_and_the_pull_plays(page):
    page.get_by_text("Set the wrap pressure").click()
    page.get_by_text(re.compile("away from the base at")).wait_for(timeout=4 * PATIENCE)
    assert page.get_by_text("(in contact)").is_visible()
    page.screenshot(path=os.environ.get("STUDIO_SCREENSHOT"))
    page.get_by_text("Play the pull").click()
    page.get_by_text(re.compile(r"pulled by [\d.]+ mm: [\d.]+ N")).first.wait_for(timeout=PATIENCE)
    page.get_by_text("(in contact)").wait_for(timeout=PATIENCE)


def test_a_file_is_edited_and_what_is_wrong_with_it_said(page):
    page.get_by_text("Gripper file", exact=True).click()
    box = page.locator("textarea").first
    text = box.input_value()
    assert "name: paper_design_70" in text
    box.fill(text.replace("beta: 70 deg", "beta: 170 deg"))
    page.get_by_text("Use this text").click()
    page.get_by_text(re.compile("fibers.beta must be")).wait_for(timeout=PATIENCE)
    box.fill(text.replace("length: 361 mm", "length: 300 mm"))
    before = tip(page)
    page.get_by_text("Use this text").click()
    wait_until(lambda: tip(page) != before)
