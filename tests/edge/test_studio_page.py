# SPDX-License-Identifier: Apache-2.0
"""The studio in a real browser: Debian's Chromium without a screen, driven by Playwright."""

import os
import re
import time
from pathlib import Path

import pytest
from browser import PATIENCE, appears, opened, studio, wait_until
from PIL import Image

from spiral_gripper import load_gripper
from spiral_gripper.studio.exports import EXPORTS
from spiral_gripper.studio.page import APPROACH_SECONDS

pytestmark = [pytest.mark.slow, pytest.mark.timeout(4 * PATIENCE)]


@pytest.fixture(scope="module")
def address():
    with studio() as served:
        yield served


@pytest.fixture
def page(address):
    with opened(address) as page:
        appears(page, "tip criterion of")
        yield page


def tip(page):
    """Return the tip's position that the page states [mm]."""
    text = page.get_by_text(re.compile("tip of the free coil at")).inner_text()
    return re.findall(r"-?\d+\.\d+", text)


def pressure(page):
    """Return the pressure that the page states [kPa]."""
    return float(re.search(r"at ([\d.]+) kPa", appears(page, r" at [\d.]+ kPa"))[1])


def test_a_slider_moves_the_pressure_and_the_mesh(page):
    slider = page.get_by_role("slider").first  # the pressure's
    shown = page.locator("canvas").first.screenshot
    before, picture, stated = tip(page), shown(), pressure(page)
    slider.focus()
    # A busy browser may lose a key.
    wait_until(lambda: slider.press("ArrowRight") or pressure(page) >= stated + 5.0)
    wait_until(lambda: tip(page) != before)
    wait_until(lambda: shown() != picture)


def test_the_approach_plays_from_nothing_to_the_wrap(page):
    wrapped, seen = page.get_by_text("perfect wrap", exact=True), set()

    def played():
        """Play once; a busy browser may see too little of it. A click during the play ends it."""
        page.get_by_text("Play the approach").click()
        end = time.monotonic() + 3.0 * APPROACH_SECONDS
        while time.monotonic() < end and not (done := len(seen) > 2 and wrapped.is_visible()):
            seen.add(str(tip(page)))
            time.sleep(0.02)
        return done

    wait_until(played)


def test_the_closing_is_computed_and_played_in_true_time(page):
    appears(page, r"\d in contact|away from the base at")
    page.get_by_text("Play the closing in real time").click()
    appears(page, r"closed at 20 kPa/s: wrapped after \d\.\d+ s, \d+ % of the tube in contact")
    wait_until(lambda: pressure(page) == pytest.approx(65.6, abs=0.1))  # where it ends


def test_the_page_is_in_the_units_that_were_chosen():
    with studio("--units", "psi,in") as address, opened(address) as page:
        appears(page, r"tip criterion of .* in: .*psi")
        appears(page, r"holds from [\d.]+ psi")
        text = page.locator("body").inner_text()
        assert "pressure [psi]" in text
        assert "object radius [in]" in text
        assert re.findall(r"\d (?:kPa|mm)\b|\[(?:kPa|mm)\]", text) == []


def downloaded(page, kind):
    """Return the file that a button exports."""
    with page.expect_download() as download:
        page.get_by_text(kind, exact=True).click()
    path = Path(download.value.suggested_filename)
    suffix, _ = EXPORTS.get(kind, (kind, None))
    assert path.name == f"paper_design_70.{suffix}"
    download.value.save_as(path)
    return path


def test_every_export_arrives(page):
    *files, html, png = (downloaded(page, kind) for kind in (*EXPORTS, "html", "png"))
    assert all(path.stat().st_size > 1000 for path in files)
    with Image.open(png) as image:
        assert len(set(image.convert("L").resize((40, 40)).tobytes())) > 5
    page.goto(html.absolute().as_uri())
    page.locator("canvas").first.wait_for()


def test_contact_and_holding_force_come_and_the_pull_plays(page):
    before = tip(page)
    page.get_by_text("Set the wrap pressure").click()
    wait_until(lambda: tip(page) != before)
    appears(page, "^perfect wrap$")
    appears(page, "away from the base at")
    page.screenshot(path=os.environ.get("STUDIO_SCREENSHOT"))
    page.get_by_text("Play the pull").click()
    appears(page, r"pulled by [\d.]+ mm: [\d.]+ N")
    appears(page, r"\(in contact\)")


def test_a_file_is_edited_and_what_is_wrong_with_it_said(page):
    page.get_by_text("Gripper file", exact=True).click()
    box = page.locator("textarea").first
    text = box.input_value()

    def use(old, new):
        assert old in text
        box.fill(text.replace(old, new))
        page.get_by_text("Use this text").click()

    before = tip(page)
    use("length: 361 mm", "length: 300 mm")
    wait_until(lambda: tip(page) != before)
    use("beta: 70 deg", "beta: 170 deg")
    appears(page, "fibers.beta must be")
    # A refused text is not that of what is shown.
    assert load_gripper(downloaded(page, "gripper file")).tube.length == 0.3
    use("length: 361 mm", "length: 310 mm")
    wait_until(lambda: not page.get_by_text("fibers.beta must be").is_visible())
