#include "station.h"

#include <string.h>

#define MAGIC 0x4C46u
#define VERSION 1u
#define AIR 1u
#define RESET 2u
#define OUTPUTS_SHIFT 8u
#define STOPPED 4u
#define DITHERS 1u
#define LETS_DOWN 2u

static uint32_t top(const station_settings *settings) { return (1u << settings->voltage_bits) - 1u; }

static uint32_t centre(const station_settings *s) {
    const int64_t counts = (int64_t)1 << s->voltage_bits;
    return (uint32_t)((s->centre_voltage - s->voltage_low) * counts / (s->voltage_high - s->voltage_low));
}

static void set_counts(station *self, uint32_t count) {
    for (size_t j = 0; j < self->settings->joints; j++) {
        self->counts[j] = count;
    }
}

/* Let out the air: first that of the supply's line, with the valves centred, then that of the hoses. */
static void dump(station *self, uint32_t time) {
    if (self->state != STATION_DUMPED) {
        self->state = STATION_DUMPED;
        self->dumped = time;
        self->opened = 0;
        set_counts(self, centre(self->settings));
    }
    self->outputs.air = 0;
    self->outputs.outputs = 0u;
}

uint8_t *station_put(uint8_t *out, uint32_t number, size_t bytes) {
    for (size_t i = bytes; i-- > 0u;) {
        *out++ = (uint8_t)(number >> (8u * i));
    }
    return out;
}

static uint8_t *put_count(uint8_t *out, uint32_t count, uint8_t bits) {
    const uint32_t end = (uint32_t)1 << bits;
    return station_put(out, count < end ? count : end, bits >= 16u ? 4u : 2u);
}

void station_reply(uint8_t kind, uint16_t sequence, const uint8_t *payload, const uint8_t *end) {
    uint8_t bytes[FRAME_MAX_SIZE];
    board_send(bytes, frame_encode(kind, sequence, payload, (size_t)(end - payload), bytes));
}

uint8_t *station_put_identity(const station_settings *s, uint8_t *out) {
    int dithers = 0;
    for (size_t i = 0; i < STATION_WAVE; i++) {
        dithers |= s->dither[i] != 0;
    }
    const uint32_t flags =
        (dithers ? DITHERS : 0u) | (s->lets_down ? LETS_DOWN : 0u) | (uint32_t)s->outputs << OUTPUTS_SHIFT;
    const uint32_t words[STATION_IDENTITY_WORDS] = {
        MAGIC, VERSION, s->joints, s->voltage_bits, s->angle_bits, s->pressure_bits, s->supply_bits,
        (uint16_t)s->voltage_low, (uint16_t)s->voltage_high, (uint16_t)s->centre_voltage,
        flags, s->shortest_cycle, s->centres_after / 1000u, s->dumps_after / 1000u};
    for (size_t i = 0; i < STATION_IDENTITY_WORDS; i++) {
        out = station_put(out, words[i], 2u);
    }
    return out;
}

uint8_t *station_put_reading(
    const station_settings *s, station_state state, const station_samples *samples, uint8_t *out) {
    out = station_put(out, (uint32_t)state | (samples->stopped ? STOPPED : 0u), 2u);
    out = put_count(out, samples->supply, s->supply_bits);
    for (size_t j = 0; j < s->joints; j++) {
        out = put_count(out, samples->angle[j], s->angle_bits);
        out = put_count(out, samples->pressure[j], s->pressure_bits);
    }
    return out;
}

static uint32_t word(const frame *taken, size_t i) {
    return (uint32_t)taken->payload[2u * i] << 8 | taken->payload[2u * i + 1u];
}

int station_is_new(station *self, uint16_t sequence) {
    const uint16_t ahead = (uint16_t)(sequence - self->last);
    if (self->numbered && (ahead == 0u || ahead >= 0x8000u)) {
        return 0;
    }
    self->last = sequence;
    self->numbered = 1;
    return 1;
}

void station_obey(station *self, const station_command *command, const station_samples *samples) {
    const int edge = command->reset && !self->reset;
    self->heard = samples->time;
    self->reset = command->reset;
    if (self->state == STATION_CENTRED || (self->state == STATION_DUMPED && edge && !samples->stopped)) {
        self->state = STATION_RUNNING;
    }
    if (self->state == STATION_RUNNING) {
        for (size_t j = 0; j < self->settings->joints; j++) {
            self->counts[j] = command->voltage[j];
        }
        self->outputs.air = command->air;
        self->outputs.outputs = command->outputs;
    }
}

/* Obey a command of the host; return whether it is a valid and a new one. */
static int obey(station *self, const frame *taken, const station_samples *samples) {
    const station_settings *s = self->settings;
    if (taken->size != 2u + 2u * (size_t)s->joints) {
        return 0;
    }
    const uint32_t flags = word(taken, 0u), outputs = flags >> OUTPUTS_SHIFT;
    station_command command = {.air = (flags & AIR) != 0u, .reset = (flags & RESET) != 0u, .outputs = (uint8_t)outputs};
    int valid = (flags & 0xFFu & ~(AIR | RESET)) == 0u && outputs >> s->outputs == 0u;
    for (size_t j = 0; j < s->joints; j++) {
        command.voltage[j] = word(taken, j + 1u);
        valid = valid && command.voltage[j] <= top(s);
    }
    if (!valid || !station_is_new(self, taken->sequence)) {
        return 0;
    }
    station_obey(self, &command, samples);
    return 1;
}

/* Make safe if nobody has spoken for some time. */
static void watch(station *self, uint32_t time) {
    const uint32_t silence = time - self->heard;
    if (silence >= self->settings->dumps_after) {
        dump(self, time);
    } else if (silence >= self->settings->centres_after && self->state == STATION_RUNNING) {
        self->state = STATION_CENTRED;
        set_counts(self, centre(self->settings));
    }
}

/* Drive the valves, with the dither unless they are opened to let the air out. */
static void drive(station *self, uint32_t time) {
    const station_settings *s = self->settings;
    int32_t dither = 0;
    if (self->state != STATION_DUMPED || s->lets_down) {
        dither = s->dither[(uint64_t)(time % s->dither_period) * STATION_WAVE / s->dither_period];
    } else if (!self->opened && time - self->dumped >= s->empties_after) {
        self->opened = 1;
        set_counts(self, top(s));
    }
    for (size_t j = 0; j < s->joints; j++) {
        const int64_t count = (int64_t)self->counts[j] + dither;
        self->outputs.voltage[j] = count < 0 ? 0u : count > (int64_t)top(s) ? top(s) : (uint32_t)count;
    }
    board_drive(&self->outputs);
}

void station_start(station *self, const station_settings *settings) {
    station_samples samples;
    memset(self, 0, sizeof *self);
    board_sample(&samples);
    self->settings = settings;
    self->heard = samples.time;
    self->reset = 1; /* low has to be seen before it rises */
    self->state = STATION_RUNNING;
    dump(self, samples.time);
}

void station_sample(station *self, station_samples *samples) {
    board_sample(samples);
    if (samples->stopped) {
        dump(self, samples->time);
    }
}

void station_finish(station *self, const station_samples *samples) {
    watch(self, samples->time);
    drive(self, samples->time);
}

/* Answer a frame; pass over one that is old, or none of a host's. */
static void answer(station *self, const frame *taken, const station_samples *samples) {
    uint8_t payload[FRAME_MAX_PAYLOAD];
    if (taken->kind == FRAME_IDENTIFY) {
        self->numbered = 0;
        station_reply(FRAME_IDENTITY, taken->sequence, payload, station_put_identity(self->settings, payload));
    } else if (taken->kind == FRAME_COMMAND && obey(self, taken, samples)) {
        drive(self, samples->time);
        station_reply(FRAME_READING, taken->sequence, payload, station_put_reading(self->settings, self->state, samples, payload));
    }
}

void station_step(station *self) {
    station_samples samples;
    uint8_t bytes[64];
    frame taken;
    station_sample(self, &samples);
    for (size_t size = board_receive(bytes, sizeof bytes), i = 0; i < size; i++) {
        if (frame_decode(&self->decoder, bytes[i], &taken)) {
            answer(self, &taken, &samples);
        }
    }
    station_finish(self, &samples);
}
