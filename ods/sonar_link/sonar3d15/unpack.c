/* Snappy blocks and packed protobuf numbers, from the network: nothing is read or written outside the arrays. */

#include "ods/compiled/kernel.h"

/* Bytes that are read in turn. */
typedef struct {
    const uint8_t *data;
    int64_t at, size;
} Source;

/* Reads `count` bytes, little endian, into `number`; returns whether they are there. */
static bool read_number(Source *source, int64_t count, int64_t *number)
{
    if (count > source->size - source->at)
        return false;
    *number = 0;
    for (int64_t k = 0; k < count; k++)
        *number |= (int64_t)source->data[source->at + k] << (8 * k);
    source->at += count;
    return true;
}

/* Reads a varint of 32 bits at most; returns whether there is one. */
static inline bool read_varint(Source *source, uint64_t *number)
{
    *number = 0;
    for (int shift = 0; shift < 35 && source->at < source->size; shift += 7) {
        const uint8_t byte = source->data[source->at++];
        *number |= (uint64_t)(byte & 0x7F) << shift;
        if (byte < 0x80)
            return *number <= UINT32_MAX;
    }
    return false;
}

/* What one element of a block adds: bytes of its own, or a copy of what was written `back` bytes before. */
typedef struct {
    int64_t length, back; /* back: 0 for bytes of its own */
} Element;

/* Reads the head of an element; returns whether it is whole. */
static bool read_element(Source *source, Element *element)
{
    const uint8_t tag = source->data[source->at++];
    const int64_t upper = tag >> 2;
    int64_t more = 0;
    switch (tag & 3) {
    case 0:
        element->back = 0;
        if (upper >= 60 && !read_number(source, upper - 59, &more))
            return false;
        element->length = (upper < 60 ? upper : more) + 1;
        return true;
    case 1:
        element->length = (upper & 7) + 4;
        if (!read_number(source, 1, &more))
            return false;
        element->back = (upper >> 3) << 8 | more;
        break;
    default:
        element->length = upper + 1;
        if (!read_number(source, (tag & 3) == 2 ? 2 : 4, &element->back))
            return false;
    }
    return element->back > 0;
}

/* Unpacks a block of Snappy's raw format, behind the varint of its length, which is that of `plain`. Tells whether it
   is one: format_description.txt of google/snappy. */
KERNEL_BOOL(unpack_snappy, "u1[:] block, out u1[:] plain")
{
    Source source = {ARRAY(uint8_t, 0), 0, SIZE(0, 0)};
    uint8_t *plain = ARRAY(uint8_t, 1);
    const int64_t room = SIZE(1, 0);
    int64_t written = 0;
    while (source.at < source.size) {
        Element element;
        if (!read_element(&source, &element) || element.length > room - written || element.back > written)
            return false;
        if (element.back == 0) {
            if (element.length > source.size - source.at)
                return false;
            memcpy(plain + written, source.data + source.at, (size_t)element.length);
            source.at += element.length;
        } else if (element.back >= element.length) {
            memcpy(plain + written, plain + written - element.back, (size_t)element.length);
        } else {
            for (int64_t k = 0; k < element.length; k++) /* what is copied may be of the copy itself */
                plain[written + k] = plain[written + k - element.back];
        }
        written += element.length;
    }
    return written == room;
}

/* Unpacks varints that fill `packed` and `pixels`, (rows, columns) in the order sent, and turns them to columns of rows.
   Tells whether they are as many, none of more than 16 bits. */
KERNEL_BOOL(unpack_pixels, "u1[:] packed, out u2[columns,rows] pixels")
{
    Source source = {ARRAY(uint8_t, 0), 0, SIZE(0, 0)};
    uint16_t *pixels = ARRAY(uint16_t, 1);
    const int64_t columns = SIZE(1, 0), rows = SIZE(1, 1);
    for (int64_t row = 0; row < rows; row++)
        for (int64_t column = 0; column < columns; column++) {
            uint64_t number;
            if (!read_varint(&source, &number) || number > UINT16_MAX)
                return false;
            pixels[column * rows + row] = (uint16_t)number;
        }
    return source.at == source.size;
}
