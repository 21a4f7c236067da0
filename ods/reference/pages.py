"""All generated pages."""

from ods.reference.counter_pages import counter_pages
from ods.reference.file_pages import file_pages
from ods.reference.message_pages import message_pages, schema
from ods.reference.package_pages import package_pages
from ods.reference.setting_pages import setting_pages


def pages() -> dict[str, str]:
    """Return every generated file of docs/: name and text."""
    made = message_pages() | setting_pages() | file_pages() | counter_pages() | package_pages()
    return {**made, "messages/messages.schema.json": schema()}
