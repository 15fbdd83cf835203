"""The arm on the operator's page, drawn by its solids while it moves."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from layflat.rig.session import STARTS_WITHIN
from tests.pages.browsers import PATIENT, PATIENT_ARM, PATIENT_HOST, chromium, served
from tests.pages.panel.driving import angle, drives, jogged, tab, until, vented

SCENE = """() => {
  const canvases = [...document.querySelectorAll("canvas")].map((one) => one.parentElement.id.slice(1));
  return getElement(Number(canvases.find((id) => id && getElement(Number(id))?.renderer)));
}"""
PLACES = """(scene) => {
  scene.scene.updateMatrixWorld();
  const found = [];
  scene.scene.traverseVisible((one) => {
    if (one.geometry?.attributes.normal && !one.geometry.index) found.push(one.matrixWorld.elements.map(Number));
  });
  return found;
}"""
"""Poses of what is drawn by triangles of files."""
DRAWN = """async (scene) => {
  const begun = performance.now(), first = scene.renderer.info.render.frame;
  for (let i = 0; i < 100; i++) {
    scene.camera.position.x += 1e-4;
    await new Promise((done) => setTimeout(done, 20));
    scene.renderer.render(scene.scene, scene.camera);
  }
  return (scene.renderer.info.render.frame - first) / (performance.now() - begun);
}"""
"""Pictures a millisecond, where the camera moves on and on."""


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    pytest.importorskip("nicegui")
    pytest.importorskip("OCP")
    folder = tmp_path_factory.mktemp("panel")
    (folder / "arm.toml").write_text(PATIENT_ARM + PATIENT_HOST, encoding="utf-8")
    with chromium() as browser, served(folder, "panel", "arm.toml", before=PATIENT) as found:
        page = found.page(browser)
        until(lambda: drives(page), 30.0)
        until(lambda: vented(page), STARTS_WITHIN)
        yield page
        until(lambda: vented(page), 30.0)
        for context in browser.contexts:
            context.close()
    assert not found.complaints


def places(page: Any) -> np.ndarray:
    """Poses of the solids that are seen, (solids, 4, 4)."""
    return np.array(page.evaluate_handle(SCENE).evaluate(PLACES)).reshape(-1, 4, 4)


def is_complete(page: Any) -> bool:
    """Whether solids are seen, and no more come while one waits."""
    count = len(places(page))
    page.wait_for_timeout(3000)
    return 10 < count == len(places(page))


def test_solids_are_seen_and_move_with_the_joint(page: Any) -> None:
    until(lambda: is_complete(page), 120.0)
    before, start = places(page), angle(page)
    assert "by rods" not in page.inner_text("main")
    jogged(page, "large, forwards", lambda: angle(page) > start + 8.0)
    page.mouse.up()
    page.wait_for_timeout(1000)
    after, turned = places(page), np.radians(angle(page) - start)
    assert after.shape == before.shape
    cosines = np.einsum("nij,nij->n", before[:, :3, :3], after[:, :3, :3]) / 2.0 - 0.5  # of how far each has turned
    still = cosines > np.cos(0.02)
    assert still.any(), "the base stands"
    assert np.isclose(np.arccos(cosines.clip(-1.0, 1.0)), turned, atol=0.03).sum() > 5, "both links turn with the joint"


def test_a_click_on_what_can_be_reached_enters_a_target_beside_the_solids(page: Any) -> None:
    until(lambda: len(places(page)) > 10, 120.0)
    tab(page, "Target")
    fields = [page.get_by_label(name) for name in ("large (deg)", "small (deg)", "tip x (mm)", "tip y (mm)")]
    box = page.locator("canvas").first.bounding_box()
    before = [field.input_value() for field in fields]

    def entered() -> bool:
        page.mouse.click(box["x"] + 0.66 * box["width"], box["y"] + 0.78 * box["height"])
        page.wait_for_timeout(1000)
        return all(field.input_value() != value for field, value in zip(fields, before, strict=True))

    until(entered, 60.0)  # the surface is searched in another process


def test_pictures_leave_two_thirds_of_the_time_to_the_page(page: Any) -> None:
    scene = page.evaluate_handle(SCENE)
    slow = """(scene) => {
      const gl = scene.renderer.getContext();
      gl.getSyncParameter = () => performance.now() > gl.ready ? gl.SIGNALED : gl.UNSIGNALED;
      const fence = gl.fenceSync.bind(gl);
      gl.fenceSync = (...all) => { gl.ready = performance.now() + 100; return fence(...all); };
    }"""
    scene.evaluate(slow)
    assert scene.evaluate(DRAWN) < 1 / 300.0 + 1e-3
