"""Sliders: what they change, in this process, and dragged by a mouse in a real browser."""

import base64
import io
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import nbformat
import numpy as np
import pytest
from nbconvert import HTMLExporter
from numpy.testing import assert_allclose
from PIL import Image
from refresh_notebooks import NOTEBOOKS, lessons

import freeseg as fs
from freeseg.explorer import PLANNERS, SLIDERS, TRACKERS, WORLDS

BROWSERS = "chromium", "chromium-browser", "google-chrome", "chrome"


@pytest.fixture
def explorer():
    return fs.Explorer()


def picture(explorer):
    return np.array(explorer.canvas.get_renderer().buffer_rgba())


def set_all(explorer, **values):
    for name, value in values.items():
        explorer.controls[name.replace("_", " ")].value = value


def test_shows_the_plan_and_the_run_of_its_values(explorer):
    set_all(explorer, start_x=50, goal_y=700, margin=8, robot=120)
    robot = fs.KheperaIV(diameter=0.12)
    expected = fs.plan(fs.load_table(1), (0.05, 0), (0.75, 0.7), robot, 0.008)
    assert_allclose(explorer.plan.path.length, expected.path.length)
    assert explorer.run.robot == robot
    assert f"path of {1000 * expected.path.length:.0f} mm" in explorer.message.value


@pytest.mark.parametrize("name", [*SLIDERS, "world", "planner", "tracker"])
def test_every_control_changes_the_picture(explorer, name):
    before, control = picture(explorer), explorer.controls[name]
    after = {"world": "Table 3", "planner": "the shortest path", "tracker": "LQR"}
    control.value = after[name] if name in after else control.value + 4 * control.step
    if name == "planner":
        # In this case both find the same path.
        assert explorer.plan.lower_bound is not None
    else:
        assert (picture(explorer) != before).any()


@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("planner", PLANNERS)
def test_every_choice_gives_a_path_or_says_why_not(explorer, world, planner):
    set_all(explorer, world=world, planner=planner)
    said = explorer.message.value
    assert ("A path of" in said) == (explorer.plan is not None)
    assert explorer.plan is not None or re.search(r"<b>(Trapped|NoPath|InvalidQuery)</b>", said)


@pytest.mark.parametrize("tracker", TRACKERS)
def test_every_tracker_drives(explorer, tracker):
    set_all(explorer, tracker=tracker, disturbance=0)
    assert fs.metrics.tracking(explorer.run)["position_rms_m"] < 0.005


def test_says_why_there_is_no_path_and_recovers(explorer):
    length = explorer.plan.path.length
    set_all(explorer, start_x=550, start_y=100)
    assert explorer.plan is explorer.run is None
    assert "<b>InvalidQuery</b>: start" in explorer.message.value
    set_all(explorer, start_x=0, start_y=0)
    assert_allclose(explorer.plan.path.length, length)


def test_disturbance_disturbs(explorer):
    errors = []
    for times in (0, 1, 4):
        set_all(explorer, disturbance=times)
        errors.append(fs.metrics.tracking(explorer.run)["position_rms_m"])
    assert errors == sorted(errors)


def test_a_picture_stands_where_there_is_no_kernel(explorer):
    shown = explorer._repr_mimebundle_()
    still = np.array(Image.open(io.BytesIO(base64.b64decode(shown["image/png"]))))
    # Path and robot are in it, as on the canvas.
    assert (still == picture(explorer)).mean() > 0.99
    set_all(explorer, goal_x=300)
    assert (still != picture(explorer)).any()
    assert "application/vnd.jupyter.widget-view+json" in shown


# --- in a browser -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def browser():
    """The system's Chromium; where there is none, or no Playwright, these tests are skipped."""
    program = next(filter(None, map(shutil.which, BROWSERS)), None)
    must = pytest.fail if os.environ.get("FREESEG_NEEDS_BROWSER") else pytest.skip
    if program is None:
        must(f"no browser: none of {', '.join(BROWSERS)} is installed")
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        must("no playwright: pip install -r tests/requirements.txt")
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture
def page(browser):
    opened = browser.new_page(viewport={"width": 1200, "height": 1000})
    yield opened
    opened.close()


@pytest.fixture
def lab(tmp_path):
    """Address of a JupyterLab that has a copy of the notebook open."""
    shutil.copy(NOTEBOOKS / "explore.ipynb", tmp_path)
    options = ["--no-browser", "--allow-root", "--port=0", "--IdentityProvider.token=secret"]
    options += ["--LabApp.expose_app_in_browser=True", f"--ServerApp.root_dir={tmp_path}"]
    log = tmp_path / "lab.log"
    environment = {**os.environ, "JUPYTER_CONFIG_DIR": str(tmp_path / "config")}
    environment |= {"JUPYTER_DATA_DIR": str(tmp_path / "data"), "PYTHONPATH": str(NOTEBOOKS.parent)}
    command = [sys.executable, "-m", "jupyterlab", *options]
    with log.open("w") as file:
        server = subprocess.Popen(command, stdout=file, stderr=file, env=environment, cwd=tmp_path)
    try:
        yield f"{address(log)}/lab/tree/explore.ipynb?token=secret"
    finally:
        server.terminate()
        server.wait(20)


def address(log):
    for _ in range(300):
        if found := re.search(r"http://(localhost|127\.0\.0\.1):\d+", log.read_text()):
            return found[0]
        time.sleep(0.2)
    raise AssertionError(f"JupyterLab did not start: {log.read_text()}")


CANVAS = ".jupyter-matplotlib-canvas-div canvas"


def pixels(page):
    return page.evaluate(f"document.querySelector('{CANVAS}').toDataURL()")


@pytest.mark.browser
def test_drag_a_slider_in_jupyterlab(lab, page):
    page.goto(lab)
    page.wait_for_function("window.jupyterapp?.commands.isEnabled('notebook:run-all-cells')")
    page.wait_for_timeout(1500)
    page.evaluate("window.jupyterapp.commands.execute('notebook:run-all-cells')")
    page.wait_for_selector(CANVAS, timeout=60_000)
    page.wait_for_selector("text=A path of")
    page.wait_for_timeout(1000)
    before, said = pixels(page), page.inner_text(".widget-html-content")
    page.locator(".noUi-handle").first.scroll_into_view_if_needed()
    handle = page.locator(".noUi-handle").first.bounding_box()
    x, y = handle["x"] + handle["width"] / 2, handle["y"] + handle["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 20, y, steps=5)
    page.mouse.up()
    page.wait_for_function(f"document.querySelector('{CANVAS}').toDataURL() != {before!r}")
    assert page.inner_text(".widget-html-content") != said


WITH_FLIPBOOKS = [
    file for file in lessons() if "const pages = " in file.read_text(encoding="utf-8")
]


@pytest.mark.browser
@pytest.mark.parametrize("file", WITH_FLIPBOOKS, ids=lambda file: file.stem)
def test_flip_the_pages_in_the_exported_page(file, page, tmp_path):
    exported, _ = HTMLExporter().from_notebook_node(nbformat.read(file, as_version=4))
    target = Path(tmp_path / "page.html")
    target.write_text(exported, encoding="utf-8")
    page.goto(target.as_uri())
    books = page.locator("figure:has(input[type=range])")
    assert books.count() == exported.count("const pages = ")
    for k in range(books.count()):
        image, slider = books.nth(k).locator("img"), books.nth(k).locator("input")
        before, label = image.get_attribute("src"), books.nth(k).inner_text()
        slider.focus()
        page.keyboard.press("Home" if slider.input_value() != "0" else "End")
        assert image.get_attribute("src") != before
        assert books.nth(k).inner_text() != label
        assert image.evaluate("image => image.decode().then(() => image.naturalWidth)") > 100
