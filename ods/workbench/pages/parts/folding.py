"""Tools that fold into a button where their row is too narrow for them; the row never has a second line."""

from collections.abc import Iterator
from contextlib import contextmanager

from nicegui import ui
from nicegui.element import Element

from ods.workbench.pages.parts.tips import tip

BAR = "tool-bar"
_CSS = f"""
.{BAR} {{ container-type: inline-size; position: relative; }}
.tool-fold {{ display: flex; align-items: center; gap: 8px; flex-wrap: nowrap; }}
.tool-fold-button {{ display: none; }}
"""
_NARROW = """
@container (max-width: {px}px) {{
  .tool-bar .tool-fold-{px} {{
    display: none; position: absolute; top: 100%; right: 0; z-index: 20; padding: 8px 12px;
    flex-direction: column; align-items: start; border-radius: 4px; box-shadow: 0 2px 8px rgba(0, 0, 0, 0.5);
    background: #ffffff;
  }}
  .body--dark .tool-bar .tool-fold-{px} {{ background: #1d2630; }}
  .tool-bar .tool-fold-{px}.open {{ display: flex; }}
  .tool-bar .tool-fold-button-{px} {{ display: inline-flex; }}
}}
"""
"""Rules that win wherever the page puts them."""
_TOGGLE = "(event) => event.currentTarget.nextElementSibling.classList.toggle('open')"


@contextmanager
def tool_bar() -> Iterator[Element]:
    """Build the row."""
    ui.add_css(_CSS)
    with ui.row().classes(f"w-full items-center no-wrap gap-2 {BAR}") as row:
        yield row


@contextmanager
def folds(icon: str, does: str, below_px: int) -> Iterator[Element]:
    """Build tools that are behind a button where the row is narrower than `below_px`, until that is clicked again."""
    ui.add_css(_NARROW.format(px=below_px))
    with ui.element("div") as whole:
        button = tip(ui.button(icon=icon).props("dense flat"), does)
        button.classes(f"tool-fold-button tool-fold-button-{below_px}").mark(f"fold {does}")
        button.on("click", js_handler=_TOGGLE)
        with ui.row().classes(f"tool-fold tool-fold-{below_px}"):
            yield whole
