"""The menu of stages that can be added, searched by name and by what they do."""

from collections.abc import Callable, Sequence

from nicegui import ui
from nicegui.elements.menu import MenuItem

from ods.pipeline.stage.configured import find_stage
from ods.workbench.model.words import sentence


def add_menu(stages: Sequence[str], add: Callable[[str], None]) -> None:
    """Build the button and its menu. add: gets the name of the stage that is chosen."""
    items: dict[str, tuple[MenuItem, str]] = {}

    def show() -> None:
        wanted = (search.value or "").lower().split()
        for name, (item, does) in items.items():
            item.set_visibility(all(word in f"{name} {does}".lower() for word in wanted))

    def first() -> None:
        found = [name for name, (item, _) in items.items() if item.visible]
        if found and search.value:
            menu.close()
            add(found[0])

    with ui.button("add stage", icon="add").props("dense flat no-caps").mark("add stage"), ui.menu() as menu:
        search = ui.input("search", on_change=show).props("dense autofocus clearable").classes("px-4")
        search.on("keydown.enter", first).mark("search stage")
        for name in stages:
            does = sentence(find_stage(name).params.__doc__ or "").removeprefix(f"{name}: ")
            item = ui.menu_item(on_click=lambda name=name: add(name)).classes("min-h-0 py-1 max-w-lg")
            with item, ui.column().classes("gap-0"):
                ui.label(name).classes("font-mono text-sm")
                ui.label(does).classes("text-xs opacity-70")
            item.mark(f"add {name}")
            items[name] = item, does
    menu.on("before-show", lambda: search.set_value(""))
