#include "frames.h"

#include <string.h>

#define VERSION 1u
#define HEAD_SIZE 4u
#define CHECK_SIZE 4u
#define LONGEST 254u /* bytes between the zeros */

/* CRC-32 of the numbers of 4 bits. */
static const uint32_t crc_of[16] = {
    0x00000000u, 0x1DB71064u, 0x3B6E20C8u, 0x26D930ACu, 0x76DC4190u, 0x6B6B51F4u,
    0x4DB26158u, 0x5005713Cu, 0xEDB88320u, 0xF00F9344u, 0xD6D6A3E8u, 0xCB61B38Cu,
    0x9B64C2B0u, 0x86D3D2D4u, 0xA00AE278u, 0xBDBDF21Cu};

static uint32_t crc32(const uint8_t *bytes, size_t size) {
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        crc = crc >> 4 ^ crc_of[crc & 0xFu];
        crc = crc >> 4 ^ crc_of[crc & 0xFu];
    }
    return crc ^ 0xFFFFFFFFu;
}

size_t frame_encode(uint8_t kind, uint16_t sequence, const uint8_t *payload, size_t size, uint8_t *out) {
    uint8_t body[HEAD_SIZE + FRAME_MAX_PAYLOAD + CHECK_SIZE] = {
        (uint8_t)VERSION, kind, (uint8_t)(sequence >> 8), (uint8_t)(sequence & 0xFFu)};
    memcpy(body + HEAD_SIZE, payload, size);
    const uint32_t check = crc32(body, HEAD_SIZE + size);
    for (size_t i = 0; i < CHECK_SIZE; i++) {
        body[HEAD_SIZE + size + i] = (uint8_t)(check >> (24u - 8u * i));
    }
    out[0] = 0u;
    size_t last = 1u, end = 2u;
    for (size_t i = 0; i < HEAD_SIZE + size + CHECK_SIZE; i++) {
        if (body[i] != 0u) {
            out[end++] = body[i];
        } else {
            out[last] = (uint8_t)(end - last);
            last = end++;
        }
    }
    out[last] = (uint8_t)(end - last);
    out[end++] = 0u;
    return end;
}

/* Undo COBS in place; return the number of bytes, 0 if it is none. */
static size_t unstuff(uint8_t *bytes, size_t size) {
    size_t at = 0u, end = 0u;
    while (at < size) {
        const size_t next = at + bytes[at];
        if (next > size) {
            return 0u;
        }
        memmove(bytes + end, bytes + at + 1u, next - at - 1u);
        end += next - at - 1u;
        at = next;
        if (at < size) {
            bytes[end++] = 0u;
        }
    }
    return end;
}

static int whole(uint8_t *bytes, size_t size, frame *found) {
    if (size <= HEAD_SIZE + CHECK_SIZE || size > LONGEST) {
        return 0;
    }
    const size_t body = unstuff(bytes, size);
    if (body < HEAD_SIZE + CHECK_SIZE) {
        return 0;
    }
    uint32_t check = 0u;
    for (size_t i = body - CHECK_SIZE; i < body; i++) {
        check = check << 8 | bytes[i];
    }
    if (crc32(bytes, body - CHECK_SIZE) != check || bytes[0] != VERSION) {
        return 0;
    }
    found->kind = bytes[1];
    found->sequence = (uint16_t)((uint16_t)bytes[2] << 8 | bytes[3]);
    found->size = body - HEAD_SIZE - CHECK_SIZE;
    memcpy(found->payload, bytes + HEAD_SIZE, found->size);
    return 1;
}

int frame_decode(frame_decoder *decoder, uint8_t byte, frame *found) {
    if (byte != 0u) {
        if (decoder->size < LONGEST) {
            decoder->bytes[decoder->size++] = byte;
        } else {
            decoder->overlong = 1;
        }
        return 0;
    }
    const size_t size = decoder->size;
    const int good = !decoder->overlong && whole(decoder->bytes, size, found);
    if (!good && (size > 0u || decoder->overlong)) {
        decoder->bad++;
    }
    decoder->size = 0u;
    decoder->overlong = 0;
    return good;
}
