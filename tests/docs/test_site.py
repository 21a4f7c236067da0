"""The site: built without a broken link or anchor, asks nothing of other hosts, shows lists and tables as such."""

import os
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

PROJECT = Path(__file__).parents[2]
LOADED = {"script": "src", "img": "src", "source": "src", "iframe": "src", "link": "href"}
UNLOADED_LINKS = {"canonical", "prev", "next", "alternate"}
MARKUP = re.compile(r"^(?:[-*+] |\d{1,2}\. |\|.*\||#+ |```)", re.MULTILINE)


class Reader(HTMLParser):
    """Collects what a page loads, and the text of its paragraphs without code."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.loaded: list[str] = []
        self.paragraphs: list[str] = []
        self._inside: list[str] = []
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        if tag in LOADED and given.get("rel") not in UNLOADED_LINKS:
            self.loaded.append(given.get(LOADED[tag]) or "")
        if tag in ("p", "code"):
            self._inside.append(tag)
        if tag == "p":
            self.paragraphs.append("")

    def handle_endtag(self, tag: str) -> None:
        if tag in self._inside:
            self._inside.remove(tag)

    def handle_data(self, data: str) -> None:
        if self._inside == ["p"]:
            self.paragraphs[-1] += data


def build(project: Path, folder: Path) -> "subprocess.CompletedProcess[str]":
    """Build the site of `project` in `folder`."""
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1"}
    return subprocess.run(command, cwd=project, env=environment, capture_output=True, text=True)


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[Path, Reader]:
    """Every page of the site, just built."""
    folder = tmp_path_factory.mktemp("site")
    built = build(PROJECT, folder)
    assert built.returncode == 0, built.stderr
    return {page.relative_to(folder): Reader(page) for page in sorted(folder.rglob("*.html"))}


def test_broken_links_are_noticed(tmp_path: Path) -> None:
    page = tmp_path / "docs" / "page.md"
    page.parent.mkdir()
    shutil.copy(PROJECT / "docs" / "root_pages.py", page.parent)
    for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md"):
        (tmp_path / name).write_text("# Page\n")
    settings = (PROJECT / "mkdocs.yml").read_text()
    (tmp_path / "mkdocs.yml").write_text(re.sub(r"^nav:\n(?:  .*\n)+", "", settings, flags=re.MULTILINE))
    page.write_text("# Page\n\n[a](../CHANGELOG.md) [b](#page)\n")
    whole = build(tmp_path, tmp_path / "site")
    assert whole.returncode == 0, whole.stderr
    page.write_text("# Page\n\n[a](gone.md) [b](../CHANGELOG.md#gone) [c](#gone) [d](../gone.md)\n")
    broken = build(tmp_path, tmp_path / "site")
    assert broken.returncode != 0
    assert broken.stderr.count("WARNING") == 4


def test_no_page_loads_anything_from_another_host(pages: dict[Path, Reader]) -> None:
    assert len(pages) > 25
    assert any(reader.loaded for reader in pages.values())
    assert not [
        (page, link) for page, reader in pages.items() for link in reader.loaded if re.match(r"(\w+:)?//", link)
    ]


def test_lists_and_tables_are_shown_as_such(pages: dict[Path, Reader]) -> None:
    assert not [
        (str(page), text) for page, reader in pages.items() for text in reader.paragraphs if MARKUP.search(text)
    ]


def test_readme_lists_the_pages_of_the_navigation() -> None:
    root_pages = {"index.md": "README.md", "contributing.md": "CONTRIBUTING.md", "changelog.md": "CHANGELOG.md"}
    settings = (PROJECT / "mkdocs.yml").read_text()
    pages = re.findall(r"([\w/-]+\.md)$", settings[settings.index("\nnav:") :], re.MULTILINE)
    readme = (PROJECT / "README.md").read_text()
    table = readme[readme.index("## Documentation") :]
    wanted = [root_pages.get(page, f"docs/{page}") for page in pages if page != "index.md"]
    assert re.findall(r"\]\(([\w/.-]+)\)", table) == [page for page in wanted if not _has_an_index(PROJECT / page)]


def _has_an_index(page: Path) -> bool:
    """Return whether a page's folder has a README that lists it."""
    return page.parent != PROJECT and page.name != "README.md" and (page.parent / "README.md").exists()


def test_every_index_lists_its_pages() -> None:
    indices = sorted((PROJECT / "docs").rglob("README.md"))
    assert len(indices) > 10
    missing = {
        str(index.parent): sorted(
            page.name
            for page in index.parent.glob("*.md")
            if page != index and not re.search(rf"\]\({re.escape(page.name)}[#)]", index.read_text())
        )
        for index in indices
    }
    assert {folder: pages for folder, pages in missing.items() if pages} == {}


def test_every_decision_is_listed() -> None:
    folder = PROJECT / "docs" / "decisions"
    listed = (folder / "README.md").read_text()
    for page in folder.glob("0*.md"):
        title = page.read_text().splitlines()[0].removeprefix("# ")
        assert f"- [{title}]({page.name})\n" in listed


def test_every_study_is_listed() -> None:
    folder = PROJECT / "docs" / "studies"
    listed = re.findall(r"^\| \[[\w.-]+\]\((\S+)\) \|", (folder / "README.md").read_text(), re.MULTILINE)
    assert sorted(listed) == sorted(page.name for page in folder.glob("*.md") if page.name != "README.md")
