/* Noise of the sensors: the samples of numpy.random.default_rng(seed).standard_normal().

   Seeds are mixed as by NumPy's SeedSequence; numbers are PCG64's (O'Neill 2014, XSL-RR 128/64); normal ones follow
   from the ziggurat of Marsaglia and Tsang (2000) with NumPy's table of widths, which model.h holds. */
#include <math.h>

#include "core.h"

#if MODEL_PLANT
__extension__ typedef unsigned __int128 wide;

static wide joined(const uint64_t words[2]) { return ((wide)words[0] << 64) | words[1]; }

static void parted(wide value, uint64_t words[2]) {
    words[0] = (uint64_t)(value >> 64);
    words[1] = (uint64_t)value;
}

static uint32_t hashed(uint32_t value, uint32_t *factor, uint32_t multiplier) {
    value ^= *factor;
    *factor *= multiplier;
    value *= *factor;
    return value ^ (value >> 16);
}

static void advance(generator *self) {
    const wide multiplier = ((wide)0x2360ED051FC65DA4u << 64) | 0x4385DF649FCCF645u;
    parted(joined(self->state) * multiplier + joined(self->increment), self->state);
}

static uint64_t next_word(generator *self) {
    advance(self);
    const uint64_t mixed = self->state[0] ^ self->state[1];
    const unsigned turn = (unsigned)(self->state[0] >> 58);
    return (mixed >> turn) | (mixed << ((64u - turn) & 63u));
}

static double next_fraction(generator *self) { return (double)(next_word(self) >> 11) * 0x1p-53; }

void noise_seed(generator *self, uint32_t seed) {
    uint32_t pool[4], factor = 0x43B0D7E5u;
    for (int i = 0; i < 4; i++) pool[i] = hashed(i == 0 ? seed : 0u, &factor, 0x931E8875u);
    for (int from = 0; from < 4; from++)
        for (int to = 0; to < 4; to++)
            if (from != to) {
                const uint32_t mixed = 0xCA01F9DDu * pool[to] - 0x4973F715u * hashed(pool[from], &factor, 0x931E8875u);
                pool[to] = mixed ^ (mixed >> 16);
            }
    uint64_t words[4];
    factor = 0x8B51F9DDu;
    for (int i = 0; i < 4; i++) {
        const uint64_t low = hashed(pool[(2 * i) % 4], &factor, 0x58F38DEDu);
        words[i] = low | ((uint64_t)hashed(pool[(2 * i + 1) % 4], &factor, 0x58F38DEDu) << 32);
    }
    const uint64_t start[2] = {words[0], words[1]}, sequence[2] = {words[2], words[3]};
    parted((joined(sequence) << 1) | 1u, self->increment);
    parted(0, self->state);
    advance(self);
    parted(joined(self->state) + joined(start), self->state);
    advance(self);
}

static double tail(generator *self, int negative) {
    for (;;) {
        const double x = -ziggurat_inverse * log1p(-next_fraction(self)), y = -log1p(-next_fraction(self));
        if (y + y > x * x) return negative ? -(ziggurat_end + x) : ziggurat_end + x;
    }
}

/* Sizes below which a sample of a layer lies under the curve; to the bit those of NumPy's table. */
static uint64_t inside(unsigned layer) {
    if (layer == 1) return 0;
    const double next = layer ? ziggurat_width[layer - 1] : ziggurat_end * 0x1p-52;
    const double size = next / ziggurat_width[layer] * 0x1p52;
    return (uint64_t)(size + 0x1p52 - 0x1p52); /* to the nearest integer, as size is less than 0x1p52 */
}

/* Height of the curve at a layer's end, where NumPy's table has a last bit of its own in a few layers: it would decide
   between numbers that are as close as the exponential function's errors. */
static double height(unsigned layer) {
    const double end = ziggurat_width[layer] * 0x1p52;
    return layer ? exp(-0.5 * end * end) : 1.0;
}

double noise_normal(generator *self) {
    for (;;) {
        const uint64_t word = next_word(self), size = (word >> 9) & 0x000FFFFFFFFFFFFFu;
        const unsigned layer = (unsigned)(word & 0xFFu);
        const double distance = (double)size * ziggurat_width[layer], x = (word >> 8) & 1u ? -distance : distance;
        if (size < inside(layer)) return x;
        if (layer == 0) return tail(self, (int)((size >> 8) & 1u));
        const double lower = height(layer), span = height(layer - 1) - lower;
        if (span * next_fraction(self) + lower < exp(-0.5 * x * x)) return x;
    }
}
#endif
