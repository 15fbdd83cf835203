/* Frames of a rig's serial line: COBS(version, kind, number, payload, CRC-32) between two zeros. */
#ifndef LAYFLAT_FRAMES_H
#define LAYFLAT_FRAMES_H

#include <stddef.h>
#include <stdint.h>

#define FRAME_MAX_PAYLOAD 240u
#define FRAME_MAX_SIZE 256u /* with both zeros, bytes */
#define FRAME_IDENTIFY 0x01u
#define FRAME_COMMAND 0x02u
#define FRAME_REQUEST 0x03u
#define FRAME_IDENTITY 0x81u
#define FRAME_READING 0x82u
#define FRAME_STATUS 0x83u
#define FRAME_SIGNALS 0x84u

typedef struct {
    uint8_t kind;
    uint16_t sequence;
    size_t size; /* of the payload, bytes */
    uint8_t payload[FRAME_MAX_PAYLOAD];
} frame;

typedef struct {
    uint8_t bytes[FRAME_MAX_SIZE];
    size_t size;    /* bytes since the last zero */
    int overlong;   /* whether they are too many for a frame */
    uint32_t bad;   /* pieces between zeros that were no frames */
} frame_decoder;

/* Write a frame with its zeros to `out`, FRAME_MAX_SIZE bytes; return its size. */
size_t frame_encode(uint8_t kind, uint16_t sequence, const uint8_t *payload, size_t size, uint8_t *out);

/* Take the next byte; return 1 if a frame ends with it, which is then in `found`, else 0. */
int frame_decode(frame_decoder *decoder, uint8_t byte, frame *found);

#endif
