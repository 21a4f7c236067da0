"""Messages of a Ping360 made byte by byte from the maker's description, apart from the codec under test."""


def u16(*numbers: int) -> bytes:
    return b"".join(bytes([number % 256, number // 256]) for number in numbers)


def message(kind: int, payload: bytes = b"", checksum: int | None = None) -> bytes:
    body = b"BR" + u16(len(payload), kind) + b"\x02\x00" + payload
    return body + u16(sum(body) % 65536 if checksum is None else checksum)


def auto_data(
    angle: int = 0,
    samples: bytes = bytes(range(200)),
    *,
    sector: tuple[int, int] = (350, 50),
    steps: int = 1,
    period: int = 1600,
    gain: int = 1,
    count: int | None = None,
) -> bytes:
    """Return a beam of automatic transmission; period 1600: 40 us, 3 cm."""
    head = bytes([1, gain]) + u16(angle, 100, period, 750, *sector) + bytes([steps, 0])
    return message(2301, head + u16(len(samples) if count is None else count, len(samples)) + samples)


def device_data(angle: int = 0, samples: bytes = bytes(200)) -> bytes:
    head = bytes([1, 1]) + u16(angle, 100, 1600, 750)
    return message(2300, head + u16(len(samples), len(samples)) + samples)


def nack(of: int, words: bytes = b"unknown message") -> bytes:
    return message(2, u16(of) + words)
