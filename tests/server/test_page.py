"""The page in a real browser, as a person uses it."""

import math
import re
import shutil
from threading import Event, Thread

import pytest

from andante.errors import InputError
from andante.landmarks.windows import elevations_rad
from andante.server.app import teaching_app
from andante.server.running import listen, serve

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
expect = playwright.expect
expect.set_options(timeout=30_000)  # machines that run tests are busy

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
ARGUMENTS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
pytestmark = pytest.mark.skipif(BROWSER is None, reason="no Chromium on this machine")


@pytest.fixture(scope="module")
def chromium():
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=BROWSER, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture
def served(make_desk):
    """A running server with a fresh desk; ``served.url`` is its address."""
    made, done = make_desk(), Event()
    made.ended = done
    address = listen("127.0.0.1", 0)
    made.url = address.url
    app = teaching_app(made.desk, host="127.0.0.1", on_saved=lambda: made.done.append(True))
    thread = Thread(target=serve, args=(app, address, done))
    thread.start()
    yield made
    done.set()
    thread.join(30)
    assert not thread.is_alive()


@pytest.fixture
def page(chromium, served):
    """The page, of which nothing may go wrong unseen, and which asks nobody else for anything."""
    opened = chromium.new_page(viewport={"width": 1280, "height": 900})
    opened.set_default_timeout(30_000)
    faults, foreign = [], []
    opened.on("pageerror", lambda error: faults.append(str(error)))
    opened.on("console", lambda one: faults.append(one.text) if one.type == "error" else None)
    opened.on("request", lambda one: None if one.url.startswith(served.url) else foreign.append(one.url))
    opened.goto(served.url)
    opened.faults = faults
    expect(opened.get_by_role("radio", name="bicycle")).to_be_checked()
    yield opened
    opened.close()
    assert foreign == []
    assert [fault for fault in faults if "status of 4" not in fault] == []


def find_the_bicycle(page):
    page.get_by_role("radio", name="bicycle").check()
    page.get_by_role("button", name="Find it").click()
    expect(page.get_by_role("heading", name="Draw a box around the landmark")).to_be_visible()
    expect(page.locator("#view")).to_have_js_property("complete", True)


def marks(page):
    """Where the box of the landmark lies on every preview: middles in shares of the picture."""
    return page.eval_on_selector_all(
        "#previews .box.landmark:not([hidden])",
        "found => found.map(one => [parseFloat(one.style.left) + parseFloat(one.style.width) / 2, "
        "parseFloat(one.style.top) + parseFloat(one.style.height) / 2].map(share => share / 100))",
    )


def drag(page, start, end):
    """Drag over the picture, places in shares of its size."""
    area = page.locator("#surface").bounding_box()
    points = [(area["x"] + x * area["width"], area["y"] + y * area["height"]) for x, y in (start, end)]
    page.mouse.move(*points[0])
    page.mouse.down()
    page.mouse.move(*points[1], steps=5)
    page.mouse.up()


def drawn(served):
    """Corners of the shed in the picture that is drawn in, in shares of it."""
    index = served.desk.state()["anchor"]["best"]
    anchor, shed = served.finder.anchor(index), served.finder.shed(index)
    low, high = elevations_rad(served.desk.surroundings.geometry)
    wide, tall = math.radians(140), high - low
    middle = 0.5 + 0.2 * anchor.width_rad / wide, (high - shed.elevation_rad) / tall
    half = shed.width_rad / wide / 2, shed.height_rad / tall / 2
    return tuple(m - h for m, h in zip(middle, half, strict=True)), tuple(
        m + h for m, h in zip(middle, half, strict=True)
    )


def test_two_landmarks_from_nothing_to_saved(page, served):
    expect(page.get_by_role("heading", name="What stands beside your landmark?")).to_be_visible()
    find_the_bicycle(page)
    assert marks(page) == []
    expect(page.get_by_role("button", name="Add landmark")).to_be_disabled()

    drag(page, *drawn(served))
    assert len(marks(page)) == 12  # at once, without asking the server
    expect(page.locator("#fit")).to_have_text("In the picture in 40 of 40 frames with the bicycle.")
    # Compared with where the shed really lies in the frames of the previews.
    wide = math.radians(110)
    low, high = elevations_rad(served.desk.surroundings.geometry)
    for index, (x, y) in zip(served.desk.state()["anchor"]["previews"], marks(page), strict=True):
        anchor, shed = served.finder.anchor(index), served.finder.shed(index)
        right = 0.2 * anchor.width_rad
        assert x == pytest.approx(0.5 + right / wide, abs=0.01)
        assert y == pytest.approx((high - shed.elevation_rad) / (high - low), abs=0.02)

    page.get_by_label("Name of the landmark").fill("shed")
    page.get_by_role("button", name="Add landmark").click()
    expect(page.locator("#taught-list li")).to_have_count(1)
    expect(page.locator("#status")).to_contain_text("shed added")

    drag(page, (0.2, 0.2), (0.3, 0.5))
    page.get_by_label("Name of the landmark").fill("birch")
    page.keyboard.press("Enter")
    expect(page.locator("#taught-list li")).to_have_count(2)

    page.get_by_role("button", name="Check and save").click()
    expect(page.get_by_role("heading", name="Is this right?")).to_be_visible()
    assert page.locator(".choice").count() == 48
    # A close look: the box takes a good part of its tile, and lies where the shed is in the picture.
    tile, mark, image = (page.locator(f".choice {part}").first.bounding_box() for part in (".picture", ".box", "img"))
    shed = served.finder.shed(0)
    assert max(mark["width"] / tile["width"], mark["height"] / tile["height"]) > 0.3
    assert mark["x"] + mark["width"] / 2 == pytest.approx(image["x"] + image["width"] / 2, abs=2)
    middle = (mark["y"] + mark["height"] / 2 - image["y"]) / image["height"]
    assert middle == pytest.approx((high - shed.elevation_rad) / (high - low), abs=0.03)
    page.locator(".choice").first.click()
    expect(page.locator("#sheets h3").first).to_contain_text("38 labels, 2 left out")
    page.get_by_role("button", name="Approve and save").click()
    expect(page.get_by_role("heading", name="Saved")).to_be_visible()
    expect(page.locator("#saved-next")).to_have_text("andante map monday")
    assert served.done == [True]
    shed, birch = served.saved[0]
    assert (shed.name, birch.name, len(shed.boxes), len(birch.boxes)) == ("shed", "birch", 38, 40)
    for index, box in shed.boxes.items():
        assert box.iou(served.finder.shed(index)) > 0.9


def test_keyboard_alone(page, served):
    page.keyboard.press("Tab")
    page.keyboard.press("Space")
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="Draw a box around the landmark")).to_be_focused()
    page.keyboard.press("Tab")
    expect(page.locator("#surface")).to_be_focused()
    page.keyboard.press("ArrowUp")  # a box above the anchor
    before = marks(page)
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowUp")
    assert [x for x, _ in marks(page)] > [x for x, _ in before]
    page.keyboard.press("Shift+ArrowRight")
    expect(page.locator("#box-words")).to_contain_text("wide")
    page.keyboard.press("Enter")
    expect(page.get_by_label("Name of the landmark")).to_be_focused()
    page.keyboard.type("shed")
    page.keyboard.press("Enter")
    expect(page.get_by_role("button", name="Check and save")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="Is this right?")).to_be_focused()
    page.keyboard.press("Tab")
    page.keyboard.press("Space")
    expect(page.locator("[aria-pressed=true]")).to_have_count(1)


def test_box_is_moved_sized_and_typed(page, served):
    find_the_bicycle(page)
    drag(page, (0.4, 0.2), (0.5, 0.4))
    width, right = page.locator("#width").input_value(), float(page.locator("#right").input_value())
    drag(page, (0.45, 0.3), (0.55, 0.3))  # inside: moved
    assert page.locator("#width").input_value() == width
    assert float(page.locator("#right").input_value()) > right
    drag(page, (0.6, 0.4), (0.7, 0.45))  # its corner: sized
    assert float(page.locator("#width").input_value()) > float(width)
    page.get_by_text("Numbers instead of a drawing").click()
    page.locator("#right").fill("-1")
    page.locator("#up").fill("0.5")
    middle = page.eval_on_selector(
        "#landmark-box", "one => parseFloat(one.style.left) + parseFloat(one.style.width) / 2"
    )
    assert middle < 50
    page.locator("#surface").focus()
    page.keyboard.press("Escape")
    expect(page.locator("#fit")).to_have_text("Draw a box first.")


def test_messages(page, served):
    page.get_by_role("radio", name="car").check()
    page.get_by_role("button", name="Find it").click()
    expect(page.get_by_role("alert")).to_contain_text("No car was found in any frame")
    page.get_by_label("Something else").select_option("cow")
    page.get_by_role("button", name="Find it").click()
    expect(page.get_by_role("alert")).to_contain_text("No cow was found in any frame")
    find_the_bicycle(page)
    expect(page.get_by_role("alert")).to_be_hidden()
    drag(page, *drawn(served))
    page.get_by_role("button", name="Add landmark").click()
    expect(page.get_by_role("alert")).to_have_text("Give the landmark a name first")
    page.get_by_label("Name of the landmark").fill("../shed")
    page.get_by_role("button", name="Add landmark").click()
    expect(page.get_by_role("alert")).to_contain_text("A landmark cannot be called '../shed'")
    page.get_by_text("Numbers instead of a drawing").click()
    page.locator("#up").fill("15")
    expect(page.locator("#fit")).to_have_class(re.compile("warn"))
    page.get_by_label("Name of the landmark").fill("shed")
    page.get_by_role("button", name="Add landmark").click()
    expect(page.get_by_role("alert")).to_contain_text("Landmark 'shed' lies outside of the picture")
    served.ended.set()
    page.wait_for_timeout(1500)
    page.get_by_role("button", name="Add landmark").click()
    expect(page.get_by_role("alert")).to_contain_text("Is andante teach still running in its terminal?")
    page.faults[:] = [one for one in page.faults if "ERR_CONNECTION" not in one]


def test_two_anchors_of_a_kind(page, served):
    find, words = (
        served.finder.find,
        "two things called 'bicycle' are in view, in frame 3 at azimuths 10 and 90 degrees",
    )

    def two(recording, name, progress, *, chosen):
        if chosen is None:
            raise InputError(words)
        return find(recording, name, progress, chosen=chosen)

    served.finder.find = two
    page.get_by_role("button", name="Find it").click()
    expect(page.get_by_role("alert")).to_contain_text("Two things called 'bicycle' are in view")
    page.get_by_label("frame", exact=True).fill("3")
    page.get_by_label("degrees", exact=True).fill("90")
    find_the_bicycle(page)
    assert served.finder.searched[0].frame == 3


def test_a_page_that_is_loaded_again_goes_on(page, served):
    find_the_bicycle(page)
    drag(page, *drawn(served))
    page.get_by_label("Name of the landmark").fill("shed")
    page.get_by_role("button", name="Add landmark").click()
    expect(page.locator("#taught-list li")).to_have_count(1)
    page.reload()
    expect(page.locator("#taught-list li")).to_have_count(1)
    page.get_by_role("button", name="Remove shed").click()
    expect(page.locator("#taught")).to_be_hidden()


def test_finger_on_a_small_screen(chromium, served):
    context = chromium.new_context(viewport={"width": 390, "height": 800}, has_touch=True, is_mobile=True)
    page = context.new_page()
    page.set_default_timeout(30_000)
    page.goto(served.url)
    page.get_by_role("radio", name="bicycle").tap()
    page.get_by_role("button", name="Find it").tap()
    expect(page.get_by_role("heading", name="Draw a box around the landmark")).to_be_visible()
    area = page.locator("#surface").bounding_box()
    touch = context.new_cdp_session(page)
    for kind, x, y in (("touchStart", 0.4, 0.2), ("touchMove", 0.5, 0.35), ("touchMove", 0.6, 0.5), ("touchEnd", 0, 0)):
        at = {"x": area["x"] + x * area["width"], "y": area["y"] + y * area["height"]}
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [] if kind == "touchEnd" else [at]})
    assert len(marks(page)) == 12
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    context.close()


def test_everything_has_a_name(page, served):
    """Whatever can be used says to a screen reader what it is."""
    find_the_bicycle(page)
    drag(page, *drawn(served))
    nameless = page.eval_on_selector_all(
        "button, input, #surface",
        "all => all.filter(one => one.offsetParent && !(one.ariaLabel || one.textContent.trim() || one.labels?.length))"
        ".map(one => one.outerHTML)",
    )
    assert nameless == []
    assert page.locator("img:not([alt])").count() == 0
    assert page.locator("html").get_attribute("lang") == "en"
