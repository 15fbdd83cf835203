/* States of FMI: copies of all numbers of an instance, in memory or as bytes with a digest. */
#include <stdlib.h>
#include <string.h>

#include "core.h"

/* Bytes of a state: a digest of token and numbers, and the numbers as this system stores them. */
typedef struct {
    uint64_t digest;
    numbers content;
} stored;

/* Return the FNV-1a digest of the token and of bytes. */
static uint64_t digest_of(const void *bytes, size_t size) {
    const unsigned char *const parts[] = {(const unsigned char *)MODEL_TOKEN, bytes};
    const size_t sizes[] = {sizeof MODEL_TOKEN, size};
    uint64_t digest = 0xCBF29CE484222325u;
    for (int part = 0; part < 2; part++)
        for (size_t i = 0; i < sizes[part]; i++) digest = (digest ^ parts[part][i]) * 0x100000001B3u;
    return digest;
}

static numbers *place_of(void **state) {
    if (!*state) *state = malloc(sizeof(numbers));
    return *state;
}

int core_keep(instance *self, void **state, const char *function) {
    if (!core_allows(self, ANY_PHASE, function)) return STATUS_ERROR;
    numbers *kept = state ? place_of(state) : NULL;
    if (!kept) return core_fail(self, "%s: no place for the state", function);
    *kept = self->now;
    return STATUS_OK;
}

int core_restore(instance *self, const void *state, const char *function) {
    if (!core_allows(self, ANY_PHASE, function)) return STATUS_ERROR;
    if (!state) return core_fail(self, "%s: the state is missing", function);
    self->now = *(const numbers *)state;
    return STATUS_OK;
}

void core_release(void **state) {
    if (!state) return;
    free(*state);
    *state = NULL;
}

size_t core_serialized_size(void) { return sizeof(stored); }

int core_serialize(const instance *self, const void *state, unsigned char *bytes, size_t size, const char *function) {
    if (!core_allows(self, ANY_PHASE, function)) return STATUS_ERROR;
    if (!state || !bytes) return core_fail(self, "%s: state or buffer is missing", function);
    if (size < sizeof(stored))
        return core_fail(self, "%s: the buffer has %zu bytes, the state %zu", function, size, sizeof(stored));
    const uint64_t digest = digest_of(state, sizeof(numbers));
    memcpy(bytes + offsetof(stored, digest), &digest, sizeof digest);
    memcpy(bytes + offsetof(stored, content), state, sizeof(numbers));
    return STATUS_OK;
}

int core_deserialize(const instance *self, const unsigned char *bytes, size_t size, void **state, const char *function) {
    if (!core_allows(self, ANY_PHASE, function)) return STATUS_ERROR;
    uint64_t digest;
    if (!bytes || !state) return core_fail(self, "%s: state or buffer is missing", function);
    if (size != sizeof(stored))
        return core_fail(self, "%s: the buffer has %zu bytes, the state %zu", function, size, sizeof(stored));
    memcpy(&digest, bytes + offsetof(stored, digest), sizeof digest);
    if (digest != digest_of(bytes + offsetof(stored, content), sizeof(numbers)))
        return core_fail(self, "%s: the bytes are no state of this model", function);
    numbers *kept = place_of(state);
    if (!kept) return core_fail(self, "%s: no place for the state", function);
    memcpy(kept, bytes + offsetof(stored, content), sizeof(numbers));
    return STATUS_OK;
}
