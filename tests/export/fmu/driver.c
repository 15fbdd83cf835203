/* An importer in C of FMUs by FMI 2.0: driver LIBRARY TOKEN CYCLE < TABLE > ROWS

   The table holds the number of inputs and their references, that of outputs and theirs, the number of cycles, and the
   inputs of each cycle; all rows are written with all digits. Wrong calls stand before and after. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <windows.h>
#define LOAD(path) LoadLibraryA(path)
#define FIND(library, name) ((anything)(void (*)(void))GetProcAddress(library, name))
#else
#include <dlfcn.h>
#define LOAD(path) dlopen(path, RTLD_NOW)
#define FIND(library, name) ((anything)dlsym(library, name))
#endif

typedef int (*anything)(void);
typedef struct {
    void (*log)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks;

static int complaints;

static void log_message(void *environment, const char *name, int status, const char *category, const char *form, ...) {
    (void)environment, (void)name, (void)category, (void)form;
    complaints += status == 3;
}

static unsigned *read_references(size_t *count) {
    if (scanf("%zu", count) != 1) exit(2);
    unsigned *references = malloc((*count + 1) * sizeof *references);
    for (size_t i = 0; i < *count; i++)
        if (scanf("%u", references + i) != 1) exit(2);
    return references;
}

int main(int count, char **words) {
    if (count != 4) return 2;
    void *library = (void *)LOAD(words[1]);
    if (!library) return 3;
    void *(*make)(const char *, int, const char *, const char *, const callbacks *, int, int) =
        (void *(*)(const char *, int, const char *, const char *, const callbacks *, int, int))FIND(library, "fmi2Instantiate");
    void (*release)(void *) = (void (*)(void *))FIND(library, "fmi2FreeInstance");
    int (*enter)(void *) = (int (*)(void *))FIND(library, "fmi2EnterInitializationMode");
    int (*leave)(void *) = (int (*)(void *))FIND(library, "fmi2ExitInitializationMode");
    int (*set)(void *, const unsigned *, size_t, const double *) =
        (int (*)(void *, const unsigned *, size_t, const double *))FIND(library, "fmi2SetReal");
    int (*get)(void *, const unsigned *, size_t, double *) =
        (int (*)(void *, const unsigned *, size_t, double *))FIND(library, "fmi2GetReal");
    int (*step)(void *, double, double, int) = (int (*)(void *, double, double, int))FIND(library, "fmi2DoStep");
    int (*keep)(void *, void **) = (int (*)(void *, void **))FIND(library, "fmi2GetFMUstate");
    int (*restore)(void *, void *) = (int (*)(void *, void *))FIND(library, "fmi2SetFMUstate");
    int (*forget)(void *, void **) = (int (*)(void *, void **))FIND(library, "fmi2FreeFMUstate");
    if (!make || !release || !enter || !leave || !set || !get || !step || !keep || !restore || !forget) return 4;

    const callbacks functions = {log_message, calloc, free, NULL, NULL};
    const double cycle = atof(words[3]);
    void *one = make("one", 1, words[2], NULL, &functions, 0, 0), *state = NULL;
    if (!one || make("one", 1, "none", NULL, &functions, 0, 0) || complaints != 1) return 5;
    if (step(one, 0.0, cycle, 1) != 3 || leave(one) != 3 || complaints != 3) return 6;
    if (enter(one) || leave(one) || keep(one, &state)) return 7;
    if (step(one, 0.0, 0.3 * cycle / 7.0, 1) != 3 || complaints != 4) return 8;

    size_t taken, shown, rows;
    unsigned *inputs = read_references(&taken), *outputs = read_references(&shown);
    double *values = malloc((taken + shown + 1) * sizeof *values);
    if (scanf("%zu", &rows) != 1) return 2;
    for (size_t k = 0; k < rows; k++) {
        for (size_t i = 0; i < taken; i++)
            if (scanf("%lf", values + i) != 1) return 2;
        if (set(one, inputs, taken, values) || step(one, (double)k * cycle, cycle, 1)) return 9;
        if (get(one, outputs, shown, values)) return 10;
        for (size_t i = 0; i < shown; i++) printf("%.17g ", values[i]);
        printf("\n");
    }
    if (restore(one, state) || step(one, 0.0, cycle, 1) || forget(one, &state) || state) return 11;
    if (get(NULL, outputs, shown, values) != 3 || get(one, NULL, 1, values) != 3 || complaints != 5) return 12;
    free(inputs), free(outputs), free(values);
    release(one);
    release(NULL);
    return 0;
}
