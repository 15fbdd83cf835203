#include "controller.h"

#include <math.h>
#include <string.h>

#define VERSION 2u /* of the identity: the last two words are a digest, in place of the watchdog's times */
#define UNRECORDED 1u
#define VENTED 1u
#define NO_JOINT 255u
#define LONGEST_SILENCE 0x7FFFFFFFu /* us, after which times no longer grow */
#define REQUEST_HEAD 24u            /* bytes before the joints' numbers */
#define JOINT_REQUEST 24u           /* bytes of a joint's numbers */
#define MICROSECONDS 1e6            /* in a second */

static rig_real value(const converter *c, uint32_t count) { return (rig_real)(c->low + c->lsb * (double)count); }

/* Return the count nearest to a value within the range; that of a centred valve for a value that is not finite. */
static uint32_t count_of(const converter *c, double number, uint32_t centre) {
    const double high = c->low + c->lsb * (double)c->top;
    if (!isfinite(number)) {
        return centre;
    }
    const double inside = number < c->low ? c->low : number > high ? high : number;
    return (uint32_t)((inside - c->low) / c->lsb + 0.5);
}

static double seconds(uint32_t time) { return (double)time / MICROSECONDS; }

static uint16_t get_short(const uint8_t *bytes) { return (uint16_t)((uint16_t)bytes[0] << 8 | bytes[1]); }

/* Shifts by constants, as in `put_single`, are single instructions of many processors. */
static uint32_t get_word(const uint8_t *bytes) {
    return (uint32_t)bytes[0] << 24 | (uint32_t)bytes[1] << 16 | (uint32_t)bytes[2] << 8 | bytes[3];
}

static double get_double(const uint8_t *bytes) {
    const uint64_t bits = (uint64_t)get_word(bytes) << 32 | get_word(bytes + 4);
    double number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

static uint8_t *put_single(uint8_t *out, rig_real number) {
    const float single = (float)number;
    uint32_t bits;
    memcpy(&bits, &single, sizeof bits);
    out[0] = (uint8_t)(bits >> 24);
    out[1] = (uint8_t)(bits >> 16);
    out[2] = (uint8_t)(bits >> 8);
    out[3] = (uint8_t)bits;
    return out + sizeof bits;
}

static void send_identity(controller *self, uint16_t sequence) {
    uint8_t payload[2u * STATION_IDENTITY_WORDS];
    uint8_t *end = station_put_identity(self->settings->station, payload);
    (void)station_put(payload + 2, VERSION, 2u);
    (void)station_put(end - 4, self->settings->digest, 4u);
    self->station.numbered = 0;
    self->known = 0;
    station_reply(FRAME_IDENTITY, sequence, payload, end);
}

/* Write the events that the host has not yet: their number so far without these, their count, number and joint of each. */
static uint8_t *put_events(const controller *self, uint8_t *out) {
    uint16_t count = (uint16_t)(self->events - self->request.events);
    if (count > CONTROLLER_EVENTS) {
        count = (uint16_t)(self->events < CONTROLLER_EVENTS ? self->events : CONTROLLER_EVENTS);
    }
    const uint16_t first = (uint16_t)(self->events - count);
    out = station_put(out, first, 2u);
    *out++ = (uint8_t)count;
    for (uint16_t i = 0; i < count; i++) {
        const uint8_t *event = self->happened[(uint16_t)(first + i) % CONTROLLER_EVENTS];
        *out++ = event[0];
        *out++ = event[1];
    }
    return out;
}

static void send_status(const controller *self, uint16_t sequence) {
    uint8_t payload[FRAME_MAX_PAYLOAD];
    const rig_supervisor_results *results = &self->results;
    uint8_t *end = station_put_reading(
        self->settings->station, (station_state)self->inputs.rig.device, &self->samples, payload);
    *end++ = (uint8_t)results->rig.state;
    *end++ = (uint8_t)results->rig.mode;
    *end++ = results->rig.vented > 0 ? (uint8_t)VENTED : (uint8_t)0u;
    *end++ = (uint8_t)results->rig.outputs;
    *end++ = (uint8_t)results->rig.fault;
    for (size_t j = 0; j < RIG_JOINTS; j++) {
        *end++ = (uint8_t)results->joints[j].fault;
    }
    end = station_put(end, self->cycles, 2u);
    station_reply(FRAME_STATUS, sequence, payload, put_events(self, end));
}

/* Send a joint's signals in the order of the host's records. */
static void send_signals(const controller *self, uint16_t sequence, size_t j) {
    uint8_t payload[1u + 4u * (MACHINE_SIGNALS + MACHINE_RECORDED)], *end = payload;
    const rig_joint_memory *memory = &self->memory.joints[j];
    const rig_real *report = (const rig_real *)&self->results.report[j];
    const rig_real signals[MACHINE_SIGNALS] = {
        memory->demand.demand, memory->velocity, memory->voltage,
        self->inputs.joints[j].angle, self->inputs.joints[j].pressure,
        memory->estimate.averaged_angle, memory->estimate.averaged_velocity,
        memory->estimate.averaged_pressure, memory->estimate.ripple, memory->air.taken};
    *end++ = (uint8_t)j;
    for (size_t i = 0; i < MACHINE_SIGNALS; i++) {
        end = put_single(end, signals[i]);
    }
    for (size_t i = 0; i < MACHINE_RECORDED; i++) {
        end = put_single(end, report[self->settings->recorded[i]]);
    }
    station_reply(FRAME_SIGNALS, sequence, payload, end);
}

/* Read a request; return whether it is one. */
static int read_request(const controller *self, const frame *taken, controller_request *out) {
    const uint8_t *bytes = taken->payload;
    if (taken->size != REQUEST_HEAD + JOINT_REQUEST * RIG_JOINTS) {
        return 0;
    }
    out->edges = get_short(bytes);
    out->outputs = bytes[2];
    out->switches = bytes[3];
    out->flags = get_short(bytes + 4);
    out->events = get_short(bytes + 6);
    out->age = get_double(bytes + 8);
    out->demand_age = get_double(bytes + 16);
    for (size_t j = 0; j < RIG_JOINTS; j++) {
        for (size_t i = 0; i < 3u; i++) {
            out->numbers[j][i] = get_double(bytes + REQUEST_HEAD + JOINT_REQUEST * j + 8u * i);
        }
    }
    const uint32_t outputs = (uint32_t)out->outputs | out->switches;
    return out->age >= 0.0 && isfinite(out->demand_age) && out->flags <= UNRECORDED &&
           outputs >> self->settings->station->outputs == 0u;
}

static void note_edge(rig_real *input, uint32_t changed, uint32_t shift) {
    if ((changed >> shift & 0xFu) != 0u) {
        *input = 1;
    }
}

/* Take a request; return whether it is a valid and a new one. The first one tells where its counts begin. */
static int take_request(controller *self, const frame *taken, uint32_t time) {
    controller_request request;
    if (!read_request(self, taken, &request) || !station_is_new(&self->station, taken->sequence)) {
        return 0;
    }
    rig_cycle_inputs *inputs = &self->inputs.rig;
    if (self->known) {
        const uint32_t changed = (uint32_t)(request.edges ^ self->request.edges);
        const uint32_t switched = (uint32_t)(request.switches ^ self->request.switches);
        const uint32_t before = (uint32_t)inputs->switched, on = (uint32_t)inputs->on;
        note_edge(&inputs->start, changed, 0u);
        note_edge(&inputs->stop, changed, 4u);
        note_edge(&inputs->hold, changed, 8u);
        note_edge(&inputs->reset, changed, 12u);
        inputs->switched = (rig_real)(before | switched);
        inputs->on = (rig_real)((on & ~switched) | (request.outputs & switched));
    }
    self->known = 1;
    self->request = request;
    self->asked = time;
    return 1;
}

/* Answer a frame. Commands of a host that runs the law itself are not obeyed: a rig has one law. */
static void answer(controller *self, const frame *taken, uint32_t time) {
    if (taken->kind == FRAME_IDENTIFY) {
        send_identity(self, taken->sequence);
    } else if (taken->kind == FRAME_REQUEST && self->begun && take_request(self, taken, time)) {
        send_status(self, taken->sequence);
        for (size_t j = 0; j < RIG_JOINTS; j++) {
            send_signals(self, taken->sequence, j);
        }
    }
}

static void fill_inputs(controller *self, uint32_t missed) {
    const controller_settings *s = self->settings;
    const station_samples *samples = &self->samples;
    if (samples->time - self->asked > LONGEST_SILENCE) {
        self->asked = samples->time - LONGEST_SILENCE;
    }
    const double silence = seconds(samples->time - self->asked);
    rig_cycle_inputs *rig = &self->inputs.rig;
    rig->answered = 1;
    rig->supply = value(&s->supply, samples->supply);
    rig->stopped = (rig_real)(samples->stopped != 0);
    rig->device = (rig_real)self->station.state;
    rig->elapsed = (rig_real)seconds(self->begun ? samples->time - self->cycled : s->cycle);
    rig->since = rig->elapsed;
    rig->age = (rig_real)(self->request.age + silence);
    rig->demand_age = (rig_real)(self->request.demand_age + silence);
    rig->missed = (rig_real)(missed > 0u);
    rig->unrecorded = (rig_real)((self->request.flags & UNRECORDED) != 0u);
    for (size_t j = 0; j < RIG_JOINTS; j++) {
        rig_joint_inputs *joint = &self->inputs.joints[j];
        joint->angle = value(&s->angle, samples->angle[j]);
        joint->pressure = value(&s->pressure, samples->pressure[j]);
        joint->requested = (rig_real)self->request.numbers[j][0];
        joint->velocity = (rig_real)self->request.numbers[j][1];
        joint->acceleration = (rig_real)self->request.numbers[j][2];
    }
}

static void keep_events(controller *self) {
    const uint32_t count = (uint32_t)self->results.rig.events;
    for (uint32_t i = 0; i < count; i++) {
        uint8_t *out = self->happened[self->events % CONTROLLER_EVENTS];
        const rig_real joint = self->results.events[i].joint;
        out[0] = (uint8_t)self->results.events[i].number;
        out[1] = joint < 0 ? (uint8_t)NO_JOINT : (uint8_t)joint;
        self->events++;
    }
}

/* Perform a control cycle: sensors, supervisor and law, valves. */
static void perform_cycle(controller *self, const station_samples *samples, uint32_t missed) {
    const controller_settings *s = self->settings;
    self->samples = *samples;
    fill_inputs(self, missed);
    rig_supervisor_cycle(s->supervisor, &self->inputs, &self->memory, &self->results, &self->workspace);
    self->begun = 1;
    self->cycled = samples->time;
    self->cycles++;
    rig_cycle_inputs *rig = &self->inputs.rig;
    rig->start = rig->stop = rig->hold = rig->reset = rig->switched = rig->on = 0;
    keep_events(self);

    const rig_cycle_results *results = &self->results.rig;
    station_command command = {
        .air = results->air > 0, .reset = results->reset > 0, .outputs = (uint8_t)results->outputs};
    for (size_t j = 0; j < RIG_JOINTS; j++) {
        command.voltage[j] = count_of(&s->voltage, (double)self->results.joints[j].voltage, (s->voltage.top + 1u) / 2u);
    }
    station_obey(&self->station, &command, samples);
}

void controller_start(controller *self, const controller_settings *settings) {
    memset(self, 0, sizeof *self);
    self->settings = settings;
    station_start(&self->station, settings->station);
    self->memory = *settings->memory;
    self->due = self->asked = self->station.heard;
    for (size_t j = 0; j < RIG_JOINTS; j++) {
        for (size_t i = 0; i < 3u; i++) {
            self->request.numbers[j][i] = NAN;
        }
    }
}

void controller_step(controller *self) {
    station_samples samples;
    uint8_t bytes[FRAME_MAX_SIZE];
    frame taken;
    station_sample(&self->station, &samples);
    for (size_t size = board_receive(bytes, sizeof bytes), i = 0; i < size; i++) {
        if (frame_decode(&self->station.decoder, bytes[i], &taken)) {
            answer(self, &taken, samples.time);
        }
    }
    const uint32_t late = samples.time - self->due;
    if (late <= LONGEST_SILENCE) {
        const uint32_t missed = late / self->settings->cycle;
        self->due += (missed + 1u) * self->settings->cycle;
        perform_cycle(self, &samples, missed);
    }
    station_finish(&self->station, &samples);
}
