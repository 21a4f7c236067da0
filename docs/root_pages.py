"""README, CONTRIBUTING and CHANGELOG as pages of the site: a hook of mkdocs, named in mkdocs.yml."""

import posixpath
import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT_PAGES = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
_ROOT = Path(__file__).parents[1]
_LINK = re.compile(r"\]\((?!\w+:|#)([^)#]+)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the root's pages to those of docs/."""
    for name, page in ROOT_PAGES.items():
        files.append(File.generated(config, page, content=(_ROOT / name).read_text(encoding="utf-8")))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn links between the root and docs/ into links between pages of the site."""
    here = page.file.src_uri
    folder = "." if here in ROOT_PAGES.values() else posixpath.join("docs", posixpath.dirname(here))
    return _LINK.sub(lambda link: f"]({_on_site(link[1], folder, posixpath.dirname(here))}", markdown)


def _on_site(link: str, folder: str, site_folder: str) -> str:
    """Return where `link`, written in the project's `folder`, leads from a page in the site's `site_folder`."""
    target = posixpath.normpath(posixpath.join(folder, link))
    page = ROOT_PAGES.get(target) or (target.removeprefix("docs/") if target.startswith("docs/") else "")
    return posixpath.relpath(page, site_folder or ".") if page else link
