"""What is made comes to the browser's own computer: pictures of views, prints, macros."""

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from selenium import webdriver
from selenium.webdriver.common.by import By

from tests.workbench.browser.conftest import Shared
from tests.workbench.browser.waiting import open_menu, until, wait_for

pytestmark = pytest.mark.slow

SHOWN = """
const view = [...document.querySelectorAll('div')].find((item) => item.fanView && item.clientWidth);
return view?.fanView.frame?.caption;
"""
CAMERA = """
const view = [...document.querySelectorAll('div')].find((item) => item[arguments[0]] && item.clientWidth);
[...view.querySelectorAll("button")].find((each) => each.innerText === "photo_camera").click();
return [view.clientWidth, view.clientHeight];
"""


def came(shared: Shared, ending: str) -> bytes:
    """Wait for a file among the downloads, and take it away."""

    def whole() -> Path | None:
        return next((file for file in shared.downloads.iterdir() if file.suffix == ending), None)

    file: Path = until(whole)
    content = file.read_bytes()
    file.unlink()
    return content


@pytest.mark.parametrize("kind", ["fanView", "chartView"])
def test_a_view_is_downloaded_as_it_is_seen(window: webdriver.Chrome, shared: Shared, kind: str) -> None:
    open_menu(window, "Image processing")
    until(lambda: window.execute_script(SHOWN))
    size = window.execute_script(CAMERA, kind)
    with Image.open(io.BytesIO(came(shared, ".png"))) as picture:
        assert list(picture.size) == size
        assert len(np.unique(np.asarray(picture.convert("RGB")).reshape(-1, 3), axis=0)) > 20  # it is not empty


def test_a_print_and_a_macro_are_downloaded_and_nothing_is_left_here(window: webdriver.Chrome, shared: Shared) -> None:
    open_menu(window, "Utilities")
    wait_for(window, "Movie of the mission")
    before = sorted(shared.folder.iterdir())
    for title, ending in (("Print", ".png"), ("Macro", ".zip")):
        card = window.find_element(By.XPATH, f"//*[contains(@class, 'q-card')][./*[text()='{title}']]")
        button = card.find_element(By.XPATH, ".//button[contains(., 'Download')]")
        window.execute_script("arguments[0].click()", button)
        content = came(shared, ending)
        if ending == ".png":
            with Image.open(io.BytesIO(content)) as picture:
                assert picture.info["Title"].startswith("figure11.toml, ping 0: ")
        else:
            assert "macro/commands.sh" in zipfile.ZipFile(io.BytesIO(content)).namelist()
    assert sorted(shared.folder.iterdir()) == before
