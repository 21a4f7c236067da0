"""A user's hand in a real browser: it finds things by what the page calls them, and counts what it does."""

from selenium import webdriver
from selenium.common.exceptions import (
    ElementClickInterceptedException,
    ElementNotInteractableException,
    StaleElementReferenceException,
)
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.remote.webelement import WebElement

from tests.workbench.browser import waiting
from tests.workbench.browser.waiting import until

FIND = """
const [label, within] = arguments;
const isIcon = (item) => item.closest(".q-icon, .material-icons");
const nameOf = (item) => {
  const walker = document.createTreeWalker(item, NodeFilter.SHOW_TEXT), words = [];
  while (walker.nextNode()) if (!isIcon(walker.currentNode.parentElement)) words.push(walker.currentNode.data.trim());
  return words.filter(Boolean);
};
const isSeen = (item) => item.clientWidth && getComputedStyle(item).visibility === "visible";
const groups = [...document.querySelectorAll(".q-card, .q-expansion-item")];
const isWithin = (group) => isSeen(group) && nameOf(group)[0]?.replace(/\\s+/, " ") === within;
const dialog = [...document.querySelectorAll(".q-dialog, .q-menu")].filter(isSeen).pop();
const places = within ? [groups.find(isWithin)] : [dialog, document];
const kinds = "button, [role=button], .q-item, .q-tab, .q-checkbox, .q-toggle, .q-radio";
for (const place of places.filter(Boolean)) {
  const found = [...place.querySelectorAll(kinds)].filter(isSeen);
  const named = found.filter((item) => item.getAttribute("aria-label") === label || nameOf(item)[0] === label);
  if (named.length) return named.pop();
}
return null;
"""
"""What can be pressed, by its first words or, where it has an icon only, its label; what is on top goes first."""


HAS_FOCUS = """
const [label, within] = arguments, item = document.activeElement;
if (within && !item.closest(within)) return false;
const isPressed = item.matches("button, [role=button], [role=tab], [role=checkbox], [role=switch], .q-item");
const words = isPressed ? item.innerText.split("\\n").map((line) => line.trim()) : [];
const field = item.closest(".q-field")?.querySelector(".q-field__label");
const named = item.closest("[aria-label]")?.ariaLabel ?? field?.innerText;
return named === label || named?.startsWith(`${label}:`) || words.includes(label);
"""
MOST_TABS = 150
DIALOG_HAS_FOCUS = """
const dialog = [...document.querySelectorAll(".q-dialog")].pop();
return !dialog || dialog.contains(document.activeElement);
"""
"""It takes the focus once it has grown: until then Tab goes through the page behind it."""


class Hand:
    """Presses of the pointer, keys, and fields that were written into."""

    def __init__(self, window: webdriver.Chrome) -> None:
        self.window = window
        self.clicks = self.keys = self.fields = 0

    def sees(self, text: str) -> None:
        """Wait until the page shows a text."""
        waiting.wait_for(self.window, text)

    def press(self, label: str, within: str = "") -> None:
        """Click at what is called so, in the card or the stage with that title if one is given."""

        def pressed() -> bool:
            found: WebElement | None = self.window.execute_script(FIND, label, within)
            return found is not None and self._clicked(found)

        until(pressed, f"{label!r} to press")
        self.clicks += 1

    def choose(self, label: str, option: str) -> None:
        """Choose from the list of a field."""
        self._at(label)
        self.press(option)

    def write(self, label: str, text: str, *, enter: bool = False) -> None:
        """Write into a field, in place of what it has."""
        field = self._at(label)
        field.send_keys(Keys.CONTROL + "a")
        field.send_keys(text + (Keys.ENTER if enter else ""))
        self.fields += 1
        self.keys += enter

    def key(self, *keys: str) -> None:
        """Press keys one after the other, wherever the focus is."""
        ActionChains(self.window).send_keys(*keys).perform()
        self.keys += len(keys)

    def type(self, text: str) -> None:
        """Write into the field that has the focus, in place of what it has."""
        chain = ActionChains(self.window).key_down(Keys.CONTROL).send_keys("a").key_up(Keys.CONTROL)
        chain.send_keys(text).perform()
        self.fields += 1

    def tab_to(self, label: str, within: str = "") -> None:
        """Press Tab until the focus is on what is called so, inside an element that a selector names."""
        until(lambda: self.window.execute_script(DIALOG_HAS_FOCUS))
        for _ in range(MOST_TABS):
            self.key(Keys.TAB)
            if self.window.execute_script(HAS_FOCUS, label, within):
                return
        raise AssertionError(f"{label!r} is not reached by Tab")

    def click_at(self, element: WebElement, x: float, y: float) -> None:
        """Click at a place of an element, px from its corner; the browser takes whole pixels from its middle."""
        size = element.size
        from_middle = round(x - size["width"] / 2), round(y - size["height"] / 2)
        ActionChains(self.window).move_to_element_with_offset(element, *from_middle).click().perform()
        self.clicks += 1

    def _at(self, label: str) -> WebElement:
        """Click at the field of that label, and return it."""
        until(lambda: self._clicked(waiting.field(self.window, label)))
        self.clicks += 1
        return waiting.field(self.window, label)

    def _clicked(self, element: WebElement) -> bool:
        try:
            if not waiting.is_at_rest(self.window, element):
                return False
            element.click()
        except (ElementClickInterceptedException, ElementNotInteractableException, StaleElementReferenceException):
            return False
        return True
