"""What a button with an icon only does, in words."""

from typing import TypeVar

from nicegui.element import Element

E = TypeVar("E", bound=Element)


def tip(element: E, words: str) -> E:
    """Show words where the pointer rests, or the focus is; they are the element's name, too."""
    return element.props(f'aria-label="{words}"').tooltip(words)
