/* Takes communication steps of an FMU's library, for `crates/vademecum-fmu/cost`, which counts the instructions.
 *
 *     cost LIBRARY RESOURCES GUID STEP WHAT COUNT
 *
 * WHAT: `step` one internal step, `ten` eleven of them, `push` three force components and one step, `look` one step
 * and six outputs. */
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void *Component;
typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*free)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static void told(void *environment, const char *name, int status, const char *category, const char *message, ...) {
    (void)environment, (void)status, (void)category;
    fprintf(stderr, "%s: %s\n", name, message);
}

static void *library;

static void *entry(const char *name) {
    void *found = dlsym(library, name);
    if (!found) {
        fprintf(stderr, "no %s\n", name);
        exit(2);
    }
    return found;
}

static void must(int status) {
    if (status) exit(3);
}

int main(int argc, char **argv) {
    if (argc != 7) return 2;
    library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        return 2;
    }
    Component (*instantiate)(const char *, int, const char *, const char *, const Callbacks *, int, int);
    int (*setup)(Component, int, double, double, int, double);
    int (*enter)(Component), (*leave)(Component), (*step)(Component, double, double, int);
    int (*set)(Component, const unsigned *, size_t, const double *);
    int (*get)(Component, const unsigned *, size_t, double *);
    int (*along)(Component, const unsigned *, size_t, const unsigned *, size_t, const double *, double *);
    void (*release)(Component);
    *(void **)&instantiate = entry("fmi2Instantiate");
    *(void **)&setup = entry("fmi2SetupExperiment");
    *(void **)&enter = entry("fmi2EnterInitializationMode");
    *(void **)&leave = entry("fmi2ExitInitializationMode");
    *(void **)&step = entry("fmi2DoStep");
    *(void **)&set = entry("fmi2SetReal");
    *(void **)&get = entry("fmi2GetReal");
    *(void **)&along = entry("fmi2GetDirectionalDerivative");
    *(void **)&release = entry("fmi2FreeInstance");

    char uri[4096];
    snprintf(uri, sizeof uri, "file://%s", argv[2]);
    Callbacks callbacks = {told, NULL, NULL, NULL, NULL};
    Component unit = instantiate("cost", 1, argv[3], uri, &callbacks, 0, 0);
    if (!unit) return 3;
    must(setup(unit, 0, 0.0, 0.0, 0, 0.0));
    must(enter(unit));
    must(leave(unit));

    double size = atof(argv[4]), time = 0.0, force[3] = {3.0, -8.0, -20.0}, moved[6];
    const char *what = argv[5];
    /* The variables of one point: force, displacement and velocity follow time, internal step and energy. */
    const unsigned forces[3] = {3, 4, 5}, shown[6] = {6, 7, 8, 9, 10, 11};
    int push = !strcmp(what, "push"), look = !strcmp(what, "look"), derive = !strcmp(what, "derive");
    if (!strcmp(what, "ten")) size *= 11.0;
    must(set(unit, forces, 3, force));
    for (long i = 0, count = atol(argv[6]); i < count; i++) {
        if (push) {
            force[2] = (double)(i % 7);
            must(set(unit, forces, 3, force));
        }
        must(step(unit, time, size, 1));
        time += size;
        if (look) must(get(unit, shown, 6, moved));
        if (derive) must(along(unit, shown, 6, forces, 3, force, moved));
    }
    release(unit);
    return 0;
}
