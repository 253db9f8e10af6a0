/* What is refused, by what code, and that nothing is touched by it. Compiled as C99 and as C++17. */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vademecum.h"

#define CHECK(condition)                                             \
    do {                                                             \
        if (!(condition)) {                                          \
            fprintf(stderr, "line %d: %s\n", __LINE__, #condition);  \
            return 1;                                                \
        }                                                            \
    } while (0)

static uint8_t file[4000000];

int main(int count, char **arguments) {
    char text[64];
    struct VdmNeeds needs;
    struct VdmOptions options;
    struct VdmBody *body = NULL;
    FILE *source = count == 2 ? fopen(arguments[1], "rb") : NULL;
    size_t length;
    CHECK(source);
    length = fread(file, 1, sizeof file, source);
    fclose(source);

    CHECK(vdm_measure(NULL, 0, NULL, &needs, text, sizeof text) == VDM_ARGUMENT && strlen(text) > 0);
    CHECK(vdm_measure(file, 10, NULL, &needs, text, sizeof text) == VDM_FILE && strlen(text) > 0);
    CHECK(vdm_measure(file, length, NULL, NULL, NULL, 0) == VDM_ARGUMENT);
    vdm_default_options(&options);
    options.precision = VDM_DOUBLE;
    options.rest_below = -1;
    CHECK(vdm_measure(file, length, &options, &needs, text, sizeof text) == VDM_BIND);
    options.rest_below = 0;
    CHECK(vdm_measure(file, length, &options, &needs, text, sizeof text) == VDM_OK);

    char *memory = (char *)malloc(needs.memory + 16);
    uint8_t *saved = NULL;
    size_t most, written;
    CHECK(memory);
    CHECK(vdm_bind(file, length, &options, (uint8_t *)memory + 1, needs.memory, &body, text,
                   sizeof text) == VDM_MEMORY && !body);
    CHECK(vdm_bind(file, length, &options, (uint8_t *)memory, needs.memory - 8, &body, text,
                   sizeof text) == VDM_MEMORY && !body);
    CHECK(vdm_bind(file, length, &options, (uint8_t *)memory, needs.memory, &body, text,
                   sizeof text) == VDM_OK && body);

    /* A body at rest without loads stays so. */
    CHECK(vdm_step(NULL, 1) == VDM_ARGUMENT && vdm_step(body, 3) == VDM_AT_REST);
    const double at[3] = {0.1, 0.05, 0}, far_away[3] = {100, 0, 0};
    const uint32_t stranger = 1000;
    const double value = 1;
    const double bad[3] = {0, 0, (double)1e308 * 10};
    struct VdmPlace place;
    CHECK(vdm_locate(body, NULL, &place) == VDM_ARGUMENT && strstr(vdm_message(body), "`point`"));
    most = vdm_saved_length(body);
    saved = (uint8_t *)malloc(most);
    CHECK(saved);
    CHECK(vdm_locate(body, far_away, &place) == VDM_LOAD && strstr(vdm_message(body), "away from the loadable surface"));
    CHECK(vdm_locate(body, bad, &place) == VDM_LOAD && strstr(vdm_message(body), "not finite"));
    CHECK(vdm_locate(body, at, &place) == VDM_OK);
    {
        const double force[3] = {1, 2, -3};
        double w[9], moved[3], energy, one;
        CHECK(vdm_push(body, &place, bad) == VDM_LOAD && strlen(vdm_message(body)) > 0);
        CHECK(vdm_push(body, &place, force) == VDM_OK);
        CHECK(vdm_step(body, 10) == VDM_OK && vdm_energy(body, &energy) == VDM_OK && energy > 0);
        CHECK(vdm_point(body, &place, 7, moved) == VDM_ARGUMENT);
        CHECK(vdm_point(body, &place, VDM_VELOCITY, moved) == VDM_OK);
        CHECK(vdm_node(body, needs.nodes, VDM_DISPLACEMENT, moved) == VDM_OUTPUT);
        CHECK(vdm_save(body, saved, most, &written) == VDM_OK);
        CHECK(vdm_step(body, 5) == VDM_OK && vdm_energy(body, &one) == VDM_OK);
        CHECK(vdm_restore(body, saved, written) == VDM_OK && vdm_step(body, 5) == VDM_OK);
        CHECK(vdm_energy(body, &energy) == VDM_OK && energy == one);
        CHECK(vdm_compliance(body, &place, (size_t)-1, w) == VDM_LOAD);
        (void)vdm_compliance(body, &place, 1, w);
    }
    if (needs.probes > 0) {
        CHECK(vdm_name(body, VDM_PROBES, 0, text, sizeof text) == VDM_OK);
        CHECK(vdm_find(body, VDM_PROBES, text) == 0);
    }
    CHECK(vdm_find(body, VDM_PATTERNS, "no such name") == -1);
    CHECK(vdm_find(body, 9, "x") == -1 && vdm_name(body, VDM_PROBES, 4000000000u, text, 4) == VDM_ARGUMENT);
    CHECK(vdm_set_parameters(body, &stranger, &value, 1) == VDM_BIND);
    CHECK(vdm_rest(body) == VDM_OK && vdm_clear(body) == VDM_OK && vdm_step(body, 1) == VDM_AT_REST);
    CHECK(strlen(vdm_status_text(-5)) > 0 && strlen(vdm_status_text(99)) > 0);
    free(saved);
    free(memory);
    return 0;
}
