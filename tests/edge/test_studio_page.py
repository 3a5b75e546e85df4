# SPDX-License-Identifier: Apache-2.0
"""The studio in a real browser: Debian's Chromium without a screen, driven by Playwright."""

import re
from pathlib import Path

import pytest
from browser import PATIENCE, appears, opened, studio, wait_until
from PIL import Image

from spiral_gripper.studio.exports import EXPORTS

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
    appears(page, r"recommended [\d.]+ kPa")  # the robot's model is that of the grip
    *files, html, png = (downloaded(page, kind) for kind in (*EXPORTS, "html", "png"))
    assert all(path.stat().st_size > 1000 for path in files)
    with Image.open(png) as image:
        assert len(set(image.convert("L").resize((40, 40)).tobytes())) > 5
    page.goto(html.absolute().as_uri())
    page.locator("canvas").first.wait_for()
