"""What the terminal of the workbench says of errors."""

import io
import logging

import pytest

from ods.base.errors import OdsError
from ods.workbench.web.server import in_one_line


@pytest.mark.parametrize(
    ("error", "said"),
    [(OdsError("reported on its page"), ""), (ValueError("no such\nthing"), "ValueError: no such thing\n")],
)
def test_an_error_of_a_handler_is_one_line_and_what_its_page_tells_none(error: Exception, said: str) -> None:
    logger, terminal = logging.Logger("as NiceGUI's", logging.INFO), io.StringIO()
    logger.addFilter(in_one_line)
    logger.addHandler(logging.StreamHandler(terminal))
    try:
        raise error
    except (OdsError, ValueError) as raised:
        logger.exception(raised)
    assert terminal.getvalue() == said
