"""What a browser sends is kept whole, under a name of its own, or not at all."""

from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from ods.base.errors import OdsError
from ods.base.files.shipped import shipped_file
from ods.workbench.engine.files import uploads
from ods.workbench.engine.files.folders import new_beside, readable
from ods.workbench.engine.files.openable import opening
from tests.workbench.serving import PROJECT

SCENE = shipped_file("scenes/figure11.toml").read_bytes()
ARIS = (PROJECT / "tests/data/aris/sample.aris").read_bytes()


class Sent:
    """A file of a browser."""

    def __init__(self, name: str, content: bytes) -> None:
        self.name, self._content = name, content

    def size(self) -> int:
        return len(self._content)

    async def iterate(self) -> AsyncIterator[bytes]:
        for begin in range(0, len(self._content), 100_000):
            yield self._content[begin : begin + 100_000]


def put_content(file: Path, content: bytes) -> Path:
    with new_beside(file) as (new, writing):
        writing.write(content)
        writing.close()
        return uploads.put(new, file)


@pytest.mark.parametrize(("name", "content"), [("mine.toml", SCENE), ("a.aris", ARIS), ("clip.avi", b"RIFF....AVI ")])
async def test_what_is_known_is_kept_and_may_be_opened(own_data: Path, name: str, content: bytes) -> None:
    for sent in (name, f"../../{name}", f"C:\\x\\{name}"):
        assert await uploads.keep(Sent(sent, content)) == own_data / "uploads" / name
    assert (own_data / "uploads" / name).read_bytes() == content
    assert opening(own_data / "uploads" / name, []).data.path == str(own_data / "uploads" / name)


@pytest.mark.parametrize(
    ("name", "content", "why"),
    [
        ("x.py", b"1", "x.py: the ending must be one of"),
        ("", b"1", "a file: the ending must be one of"),
        ("..", b"1", "..: the ending must be one of"),
        ("x.npz", b"1", "not kept: x.npz: "),
        ("x.mcap", b"\x89MCAP0\r\n", "not kept: x.mcap: "),
        ("x.aris", ARIS[:2000], "not kept: x.aris: "),
        ("x.avi", b"\0" * 99, "not kept: not a clip"),
        ("x.toml", b"[bus]\n", "not kept: x.toml: "),
    ],
)
async def test_what_is_not_is_one_line_and_nothing_is_left(own_data: Path, name: str, content: bytes, why: str) -> None:
    with pytest.raises(OdsError) as error:
        await uploads.keep(Sent(name, content))
    assert str(error.value).startswith(why)
    assert "\n" not in str(error.value)
    assert [each for each in own_data.rglob("*") if each.is_file()] == []


async def test_what_is_too_large_is_not_even_written(own_data: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uploads, "MOST_BYTES", len(ARIS) - 1)
    with pytest.raises(OdsError, match="are the most"):
        await uploads.keep(Sent("a.aris", ARIS))
    assert list((own_data / "uploads").iterdir()) == []


def test_a_file_never_takes_anothers_place(tmp_path: Path) -> None:
    first = tmp_path / "x.npz"
    assert (put_content(first, b"1"), put_content(first, b"1")) == (first, first)
    assert put_content(first, b"2") == tmp_path / "x-1.npz"
    assert put_content(first, b"2") == tmp_path / "x-1.npz"
    assert put_content(first, b"3" * 999).read_bytes() == b"3" * 999
    assert first.read_bytes() == b"1"
    assert sorted(each.name for each in tmp_path.iterdir()) == ["x-1.npz", "x-2.npz", "x.npz"]


def test_what_is_not_sent_to_its_end_is_not_kept(tmp_path: Path) -> None:
    with new_beside(tmp_path / "x.npz") as (_, writing):
        writing.write(b"1" * 999)
    assert list(tmp_path.iterdir()) == []


def test_the_rest_of_the_users_data_is_not_read(own_data: Path) -> None:
    own_data.mkdir()
    (own_data / "recent.json").write_text("[]")
    with pytest.raises(OdsError, match="not under the workbench's folders"):
        readable(own_data / "recent.json", [])
