"""Each page has one reader who reads it in one sitting: no page is longer than that."""

from pathlib import Path

PROJECT = Path(__file__).parents[2]
MOST_WORDS = 1500


def words(page: Path) -> int:
    """Return how many words a page has; the bars and lines of tables are none."""
    return sum(any(letter.isalnum() for letter in word) for word in page.read_text().split())


def test_no_page_is_longer_than_a_sitting() -> None:
    pages = [*(PROJECT / "docs").rglob("*.md"), PROJECT / "README.md", PROJECT / "CONTRIBUTING.md"]
    counted = {str(page.relative_to(PROJECT)): words(page) for page in pages}
    assert len(counted) > 100
    assert {page: count for page, count in counted.items() if count > MOST_WORDS} == {}
