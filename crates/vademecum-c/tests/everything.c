/* Every call of the interface on the file that is given, as far as the file holds what it asks for; prints what was
   covered. Compiled as C99 and as C++17, run under valgrind and with sanitizers. */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vademecum.h"

#define CHECK(condition)                                             \
    do {                                                             \
        if (!(condition)) {                                          \
            fprintf(stderr, "line %d: %s: %s\n", __LINE__, #condition, body ? vdm_message(body) : ""); \
            exit(1);                                                 \
        }                                                            \
    } while (0)

static uint8_t *file;
static size_t length;

/* A body over memory of the exact length that was asked for. */
struct Bound {
    struct VdmBody *body;
    struct VdmNeeds needs;
    uint8_t *memory;
    double *work;
};

static struct Bound bound(const struct VdmOptions *options) {
    char text[240] = "";
    struct Bound b;
    struct VdmBody *body = NULL;
    CHECK(vdm_measure(file, length, options, &b.needs, text, sizeof text) == VDM_OK);
    b.memory = (uint8_t *)malloc(b.needs.memory);
    b.work = (double *)malloc((b.needs.work + 1) * sizeof(double));
    CHECK(b.memory && b.work);
    CHECK(vdm_bind(file, length, options, b.memory, b.needs.memory, b.work, b.needs.work, &body, text, sizeof text) ==
          VDM_OK);
    b.body = body;
    return b;
}

static enum VdmStatus rebound(struct Bound *b, const struct VdmOptions *options) {
    return vdm_bind(file, length, options, b->memory, b->needs.memory, b->work, b->needs.work, &b->body, NULL, 0);
}

static void released(struct Bound *b) {
    free(b->memory);
    free(b->work);
}

static int same(const void *a, const void *b, size_t bytes) {
    return memcmp(a, b, bytes) == 0;
}

/* Loads that change within a step, kept loads, and places that are nodes. */
static void loads(struct VdmOptions options) {
    struct Bound b;
    struct VdmBody *body = NULL;
    struct VdmPlace place;
    double at[4], held[3] = {1.0, -2.0, -20.0}, none[3] = {0, 0, 0}, half[3], moved[3], other[3], amplitudes[4];
    double *saved, *again;
    uint32_t node;
    int k;
    options.keep_loads = 1;
    b = bound(&options);
    body = b.body;
    node = b.needs.load_nodes - 1;
    saved = (double *)malloc(b.needs.state * sizeof(double));
    again = (double *)malloc(b.needs.state * sizeof(double));
    CHECK(saved && again);
    CHECK(vdm_instants(body, at) == VDM_OK && at[0] == 0.0 && at[1] > 0.0 && at[1] <= 1.0);
    CHECK(vdm_at_node(body, b.needs.load_nodes, &place) == VDM_LOAD);
    CHECK(vdm_at_node(body, b.needs.load_nodes - 1, &place) == VDM_OK && place.weights[0] == 1.0 && place.nodes[2] == node);

    /* A ramp between two equal forces is a held force, to rounding; half of one, a force of half the size. */
    CHECK(vdm_add_contact(body, &place, held) == VDM_OK && vdm_keep_loads(body) == VDM_OK);
    CHECK(vdm_step(body, 3) == VDM_OK && vdm_node(body, node, VDM_DISPLACEMENT, moved) == VDM_OK);
    CHECK(vdm_rest(body) == VDM_OK && vdm_clear_loads(body) == VDM_OK);
    CHECK(vdm_add_contact_ramp(body, &place, held, held) == VDM_OK && vdm_step(body, 3) == VDM_OK);
    CHECK(vdm_node(body, node, VDM_DISPLACEMENT, other) == VDM_OK);
    for (k = 0; k < 3; k++) CHECK(other[k] - moved[k] <= 1e-9 && moved[k] - other[k] <= 1e-9);
    CHECK(moved[2] < 0);
    CHECK(vdm_rest(body) == VDM_OK && vdm_recall_loads(body) == VDM_OK && vdm_step(body, 3) == VDM_OK);
    CHECK(vdm_node(body, node, VDM_DISPLACEMENT, other) == VDM_OK && same(moved, other, sizeof moved));

    /* A force that rises, as a ramp and by its amplitudes: the same bits. */
    CHECK(vdm_rest(body) == VDM_OK && vdm_clear_loads(body) == VDM_OK);
    CHECK(vdm_add_contact_staged(body, &place, held, at) == VDM_OK && vdm_step(body, 1) == VDM_OK);
    CHECK(vdm_save(body, saved, b.needs.state) == VDM_OK);
    CHECK(vdm_rest(body) == VDM_OK && vdm_clear_loads(body) == VDM_OK);
    CHECK(vdm_add_contact_ramp(body, &place, none, held) == VDM_OK && vdm_step(body, 1) == VDM_OK);
    CHECK(vdm_save(body, again, b.needs.state) == VDM_OK && same(saved, again, b.needs.state * sizeof(double)));
    half[0] = half[1] = half[2] = (double)1e308 * 10;
    CHECK(vdm_add_contact_ramp(body, &place, none, half) == VDM_LOAD);
    amplitudes[0] = amplitudes[1] = amplitudes[2] = amplitudes[3] = half[0];
    CHECK(vdm_add_contact_staged(body, &place, held, amplitudes) == VDM_LOAD);
    printf("loads\n");

    if (b.needs.patterns > 0) {
        CHECK(vdm_rest(body) == VDM_OK && vdm_clear_loads(body) == VDM_OK);
        CHECK(vdm_add_pattern_ramp(body, 0, 0.0, 1.0) == VDM_OK && vdm_step(body, 1) == VDM_OK);
        CHECK(vdm_save(body, saved, b.needs.state) == VDM_OK);
        CHECK(vdm_rest(body) == VDM_OK && vdm_clear_loads(body) == VDM_OK);
        CHECK(vdm_add_pattern_staged(body, 0, at) == VDM_OK && vdm_step(body, 1) == VDM_OK);
        CHECK(vdm_save(body, again, b.needs.state) == VDM_OK);
        CHECK(same(saved, again, b.needs.state * sizeof(double)));
        CHECK(vdm_add_pattern_staged(body, b.needs.patterns, at) == VDM_LOAD);
        printf("patterns\n");
    }
    if (vdm_stress_points(body) > 0) {
        uint32_t where[2] = {99, 99};
        double stress[6], strain[6];
        CHECK(vdm_rest(body) == VDM_OK && vdm_clear_loads(body) == VDM_OK);
        CHECK(vdm_add_contact(body, &place, held) == VDM_OK && vdm_step(body, 1) == VDM_OK);
        CHECK(vdm_stress_point(body, 0, where) == VDM_OK && where[0] < 99 && where[1] < 99);
        CHECK(vdm_stress(body, 0, stress) == VDM_OK && vdm_von_mises(stress) > 0);
        CHECK(vdm_strain(body, 0, strain) == VDM_OK && strain[3] * stress[3] > 0);
        CHECK(vdm_stress(body, vdm_stress_points(body), stress) == VDM_OUTPUT);
        CHECK(vdm_stress(NULL, 0, stress) == VDM_ARGUMENT && vdm_strain(body, 0, NULL) == VDM_ARGUMENT);
        CHECK(vdm_stress_points(NULL) == 0 && vdm_stress_point(body, 1u << 20, where) == VDM_ARGUMENT);
        CHECK(vdm_von_mises(NULL) != vdm_von_mises(NULL));
        printf("stress\n");
    }
    if (vdm_find(body, VDM_SUPPORTS, "left") == 0) {
        double exerted[6] = {0, 0, 0, 0, 0, 0};
        CHECK(vdm_rest(body) == VDM_OK && vdm_clear_loads(body) == VDM_OK);
        CHECK(vdm_add_contact(body, &place, held) == VDM_OK && vdm_step(body, 1) == VDM_OK);
        CHECK(vdm_reaction(body, 0, exerted) == VDM_OK && exerted[2] != 0);
        CHECK(vdm_reaction(body, 99, exerted) == VDM_OUTPUT && vdm_reaction(body, 0, NULL) == VDM_ARGUMENT);
        printf("reactions\n");
    }
    CHECK(vdm_rest(body) == VDM_OK && vdm_clear_loads(body) == VDM_OK);
    CHECK(vdm_add_base(body, held, none, NULL) == VDM_ARGUMENT);
    if (vdm_find(body, VDM_PATTERNS, "base.ax") >= 0) {
        CHECK(vdm_add_base(body, held, none, none) == VDM_OK && vdm_step(body, 1) == VDM_OK);
        CHECK(vdm_node(body, node, VDM_DISPLACEMENT, moved) == VDM_OK && moved[2] != 0);
        CHECK(vdm_add_base(body, none, half, none) == VDM_LOAD);
        printf("base\n");
    } else {
        CHECK(vdm_add_base(body, held, none, none) == VDM_LOAD);
    }
    free(again);
    free(saved);
    released(&b);

    options.keep_loads = 0;
    b = bound(&options);
    body = b.body;
    CHECK(vdm_keep_loads(body) == VDM_MEMORY && strlen(vdm_message(body)) > 0);
    CHECK(vdm_recall_loads(body) == VDM_MEMORY);
    released(&b);
}

/* States: set, read, carried to a body with half the step; places solved for. */
static void states(struct VdmOptions options) {
    const double force[3] = {0, 0, -10};
    struct Bound b = bound(&options), other;
    struct VdmBody *body = b.body;
    struct VdmPlace place;
    double *zeta = (double *)calloc(b.needs.modes, sizeof(double)), *rate = (double *)calloc(b.needs.modes, sizeof(double));
    double *read = (double *)calloc(b.needs.modes, sizeof(double)), *speed = (double *)calloc(b.needs.modes, sizeof(double));
    double w[9], gone[3], moved[3], there, here, rest;
    const int strain = vdm_structure(body) == VDM_STRAIN;
    const size_t parts = strain || vdm_structure(body) == VDM_EXACT ? 2 : 3, rows = parts * b.needs.modes;
    double *map = (double *)malloc(rows * rows * sizeof(double));
    struct VdmCost cost, finer;
    uint32_t k;
    CHECK(zeta && rate && read && speed && map);
    zeta[0] = 1e-3;
    rate[0] = 0.5;
    CHECK(vdm_set(body, zeta, rate, b.needs.modes) == VDM_OK && vdm_set(body, zeta, rate, 1 + b.needs.modes) == VDM_STEP);
    CHECK(vdm_coordinates(body, read, speed, b.needs.modes) == VDM_OK);
    for (k = 0; k < b.needs.modes; k++) {
        CHECK(read[k] - zeta[k] < 1e-9 && zeta[k] - read[k] < 1e-9);
        CHECK(speed[k] - rate[k] < 1e-6 && rate[k] - speed[k] < 1e-6);
    }
    CHECK(vdm_coordinates(body, read, speed, 0) == VDM_STEP);
    CHECK(vdm_cost(body, &cost) == VDM_OK && cost.step_operations > 0 && cost.step_bytes > 0);
    CHECK(vdm_increment(body, map, rows * rows) == (strain ? VDM_OUTPUT : VDM_OK));
    CHECK(vdm_increment(body, map, 1) == VDM_OUTPUT);
    CHECK(vdm_energy_at_rest(body, &rest) == VDM_OK && rest >= 0);
    CHECK(vdm_carry(body, body) == VDM_OK && vdm_carry(body, NULL) == VDM_ARGUMENT);

    /* Another body of the same file, with half the step where it allows one. */
    if (vdm_structure(body) != VDM_BLOCK) options.time_step = 0.5 * b.needs.time_step;
    other = bound(&options);
    CHECK(vdm_carry(other.body, body) == VDM_OK);
    CHECK(vdm_energy(body, &here) == VDM_OK && vdm_energy(other.body, &there) == VDM_OK);
    CHECK(here > 0 && there - here < 1e-5 * here && here - there < 1e-5 * here);
    printf("states\n");

    /* Sub-steps are a choice of who binds; the other structures have none. */
    released(&other);
    options.substeps = 3;
    other = bound(&options);
    CHECK(vdm_cost(other.body, &finer) == VDM_OK);
    CHECK(strain == (finer.step_operations > 2 * cost.step_operations));
    options.substeps = 1025;
    CHECK((rebound(&other, &options) == VDM_BIND) == strain);
    options.viscosity = -1;
    options.substeps = 3;
    CHECK((rebound(&other, &options) == VDM_BIND) == strain);

    if (vdm_structure(body) != VDM_BLOCK) {
        CHECK(vdm_at_node(body, b.needs.load_nodes - 1, &place) == VDM_OK);
        CHECK(vdm_compliance(body, &place, 1, w) == VDM_OK && w[0] > 0 && w[8] > 0);
        CHECK(vdm_free_motion(body, &place, 1, gone) == VDM_OK);
        CHECK(vdm_add_contact(body, &place, force) == VDM_OK && vdm_step(body, 1) == VDM_OK);
        CHECK(vdm_point(body, &place, VDM_DISPLACEMENT, moved) == VDM_OK);
        for (k = 0; k < 3; k++) {
            const double left = gone[k] - 10 * w[3 * k + 2] - moved[k], size = 1e-3 * (w[8] * 10 + 1e-9);
            CHECK(left < size && -left < size);
        }
        printf("operator\n");
    }
    released(&other);
    released(&b);
    free(map);
    free(speed);
    free(read);
    free(rate);
    free(zeta);
}

/* Fields and the shape at rest, in both precisions. */
static void fields(struct VdmOptions options) {
    const double force[3] = {3, 2, -10};
    struct Bound b = bound(&options);
    struct VdmBody *body = b.body;
    const size_t surface = 3 * (size_t)b.needs.surface_nodes, all = 3 * (size_t)b.needs.nodes;
    double *at = (double *)malloc((surface + 1) * sizeof(double)), *wide = (double *)malloc((all + 1) * sizeof(double));
    double *plain = (double *)malloc((all + 1) * sizeof(double));
    uint32_t *nodes = (uint32_t *)malloc((3 * (size_t)b.needs.triangles + 1) * sizeof(uint32_t)), k;
    float *narrow = (float *)malloc((all + 1) * sizeof(float));
    struct VdmPlace place;
    size_t bytes;
    CHECK(at && wide && plain && nodes && narrow);
    CHECK(vdm_at_node(body, b.needs.load_nodes - 1, &place) == VDM_OK);
    CHECK(vdm_positions(body, at, surface + 1) == VDM_OUTPUT && vdm_triangles(body, nodes, 1) == VDM_OUTPUT);
    if (vdm_positions(body, at, surface) == VDM_OK) {
        CHECK(vdm_triangles(body, nodes, 3 * (size_t)b.needs.triangles) == VDM_OK);
        for (k = 0; k < 3 * b.needs.triangles; k++) CHECK(nodes[k] < b.needs.surface_nodes);
        CHECK(place.position[0] == at[3 * place.nodes[0]] && place.position[2] == at[3 * place.nodes[0] + 2]);
        printf("shape\n");
    }
    CHECK(vdm_add_contact(body, &place, force) == VDM_OK && vdm_step(body, 20) == VDM_OK);
    if (options.precision == VDM_DOUBLE) {
        CHECK(vdm_surface_f64(body, VDM_VELOCITY, wide, surface) == VDM_OK);
        CHECK(vdm_surface_f32(body, VDM_VELOCITY, narrow, surface) == VDM_ARGUMENT);
        CHECK(vdm_body_f32(body, VDM_VELOCITY, narrow, all) == VDM_ARGUMENT);
        if (vdm_body_f64(body, VDM_VELOCITY, plain, all) == VDM_OK) {
            CHECK(same(wide, plain, surface * sizeof(double)));
            printf("body\n");
        }
    } else {
        CHECK(vdm_surface_f32(body, VDM_VELOCITY, narrow, surface) == VDM_OK);
        CHECK(vdm_surface_f64(body, VDM_VELOCITY, wide, surface) == VDM_ARGUMENT);
        CHECK(vdm_body_f64(body, VDM_VELOCITY, wide, all) == VDM_ARGUMENT);
        CHECK(vdm_body_f32(body, 5, narrow, all) == VDM_ARGUMENT);
        CHECK(vdm_static_body_f64(body, VDM_VELOCITY, wide, all) == VDM_ARGUMENT);
    }
    printf("fields\n");

    bytes = vdm_static_bytes(body);
    CHECK(vdm_static_solve(body) == VDM_OUTPUT);
    CHECK(vdm_static_surface_f32(body, VDM_DISPLACEMENT, narrow, surface) < 0);
    CHECK(vdm_static_surface_f64(body, VDM_DISPLACEMENT, wide, surface) < 0);
    if (bytes > 0 && options.precision == VDM_DOUBLE) {
        uint8_t *memory = (uint8_t *)malloc(bytes);
        double largest = 0;
        CHECK(memory && vdm_static_lend(body, memory, bytes - 1) == VDM_MEMORY && vdm_static_lend(body, NULL, 0) < 0);
        CHECK(vdm_static_lend(body, memory, bytes) == VDM_OK && vdm_static_solve(body) == VDM_OK);
        CHECK(vdm_static_body_f64(body, VDM_DISPLACEMENT, wide, all) == VDM_OK);
        CHECK(vdm_body_f64(body, VDM_DISPLACEMENT, plain, all) == VDM_OK);
        /* At the loaded node both show the whole answer; elsewhere only one of them does. */
        for (k = 3 * place.nodes[0]; k < 3 * place.nodes[0] + 3; k++) {
            const double apart = wide[k] - plain[k], size = 1e-9 * (wide[k] < 0 ? -wide[k] : wide[k]);
            CHECK(wide[k] != 0 && apart <= size && -apart <= size);
        }
        for (k = 0; k < all; k++) {
            const double apart = wide[k] < plain[k] ? plain[k] - wide[k] : wide[k] - plain[k];
            if (apart > largest) largest = apart;
        }
        CHECK(largest > 0);
        CHECK(vdm_static_surface_f64(body, VDM_DISPLACEMENT, plain, surface) == VDM_OK);
        CHECK(same(plain, wide, surface * sizeof(double)));
        free(memory);
        printf("statics\n");
    }
    free(narrow);
    free(nodes);
    free(plain);
    free(wide);
    free(at);
    released(&b);
}

/* Live parameters, and the modes of a dense step. */
static void live(struct VdmOptions options) {
    const double force[3] = {0, 0, -10};
    struct Bound b = bound(&options);
    struct VdmBody *body = b.body;
    struct VdmParameter one;
    struct VdmPlace place;
    double *values = (double *)malloc((b.needs.parameters + 1) * sizeof(double)), dense, modal;
    size_t bytes, numbers;
    uint32_t k;
    CHECK(values && vdm_parameter(body, b.needs.parameters, &one) == VDM_ARGUMENT);
    CHECK(vdm_modal_march(body, 1) == VDM_ARGUMENT);
    for (k = 0; k < b.needs.parameters; k++) {
        CHECK(vdm_parameter(body, k, &one) == VDM_OK && one.lower <= one.value && one.value <= one.upper);
        values[k] = 0.75 * one.nominal + 0.25 * one.upper;
        printf("parameter\n");
    }
    CHECK(vdm_set_parameters(body, values, b.needs.parameters + 1, b.work, b.needs.work) == VDM_ARGUMENT);
    if (b.needs.parameters > 0) {
        CHECK(vdm_set_parameters(body, values, b.needs.parameters, b.work, b.needs.work) == VDM_OK);
        CHECK(vdm_parameter(body, 0, &one) == VDM_OK && one.value == values[0]);
        values[0] = one.upper * 2;
        CHECK(vdm_set_parameters(body, values, b.needs.parameters, b.work, b.needs.work) == VDM_BIND);
        CHECK(vdm_parameter(body, 0, &one) == VDM_OK && one.value != values[0]);
    }
    CHECK(vdm_modal_needs(body, &bytes, &numbers) == VDM_OK);
    if (bytes > 0) {
        uint8_t *memory = (uint8_t *)malloc(bytes);
        double *work = (double *)malloc((numbers + 1) * sizeof(double));
        CHECK(memory && work && vdm_modal_bind(body, 1e-5, memory, bytes - 1, work, numbers) == VDM_BIND);
        CHECK(vdm_modal_bind(body, 1e-2, memory, bytes, work, numbers) == VDM_OK);
        CHECK(vdm_at_node(body, b.needs.load_nodes - 1, &place) == VDM_OK && vdm_add_contact(body, &place, force) == VDM_OK);
        CHECK(vdm_modal_march(body, 20) == VDM_OK && vdm_energy(body, &modal) == VDM_OK);
        CHECK(vdm_rest(body) == VDM_OK && vdm_step(body, 20) == VDM_OK && vdm_energy(body, &dense) == VDM_OK);
        CHECK(dense > 0 && modal - dense < 1e-2 * dense && dense - modal < 1e-2 * dense);
        free(work);
        free(memory);
        printf("modes\n");
    }
    free(values);
    released(&b);
}

/* Many instances have the bits of one. */
static void batch(struct VdmOptions options) {
    const size_t count = 21;
    struct Bound b = bound(&options), twin;
    struct VdmBody *body = b.body;
    struct VdmBatch *many = NULL;
    struct VdmBatchStatus found;
    struct VdmPlace place;
    double *one = (double *)malloc(b.needs.state * sizeof(double)), *other = (double *)malloc(b.needs.state * sizeof(double));
    const size_t bytes = vdm_batch_bytes(body, count);
    uint8_t *memory = (uint8_t *)malloc(bytes);
    size_t k;
    CHECK(one && other && memory && vdm_batch_bytes(NULL, 1) == 0 && vdm_batch_bytes(body, (size_t)-1) == (size_t)-1);
    CHECK(vdm_batch_bind(body, count, memory, bytes - 1, &many) == VDM_MEMORY && !many);
    CHECK(vdm_batch_bind(body, count, NULL, bytes, &many) == VDM_MEMORY && !many);
    CHECK(vdm_batch_bind(body, count, memory, bytes, &many) == VDM_OK && many);
    CHECK(vdm_batch_step(many, body, 1, &found) == VDM_AT_REST && found.at_rest == count);
    CHECK(vdm_batch_load(many, NULL, 0) == VDM_ARGUMENT && vdm_batch_load(NULL, body, 0) == VDM_ARGUMENT);
    CHECK(vdm_at_node(body, b.needs.load_nodes - 1, &place) == VDM_OK);
    for (k = 0; k < count; k++) {
        const double force[3] = {0, 1, -(double)k};
        CHECK(vdm_clear_loads(body) == VDM_OK && vdm_add_contact(body, &place, force) == VDM_OK);
        CHECK(vdm_batch_load(many, body, k) == VDM_OK);
    }
    CHECK(vdm_batch_load(many, body, count) == VDM_LOAD);
    CHECK(vdm_batch_step(many, body, 7, &found) == VDM_OK && found.moving == count && found.refused == 0);
    twin = bound(&options);
    {
        const double force[3] = {0, 1, -20};
        /* The batch has made a step at rest before. */
        CHECK(vdm_step(twin.body, 1) == VDM_AT_REST);
        CHECK(vdm_add_contact(twin.body, &place, force) == VDM_OK && vdm_step(twin.body, 7) == VDM_OK);
    }
    CHECK(vdm_batch_status(many, body, 20) == VDM_OK && vdm_batch_status(many, body, count) == VDM_STEP);
    CHECK(vdm_batch_get(many, body, 20) == VDM_OK && vdm_save(body, one, b.needs.state) == VDM_OK);
    CHECK(vdm_save(twin.body, other, b.needs.state) == VDM_OK);
    CHECK(same(one, other, b.needs.state * sizeof(double)));
    if (vdm_find(body, VDM_SUPPORTS, "left") == 0) {
        double alone[6], here[6];
        CHECK(vdm_reaction(body, 0, here) == VDM_OUTPUT && strstr(vdm_message(body), "not remembered"));
        CHECK(vdm_batch_get_under(many, body, 20) == VDM_OK && vdm_reaction(body, 0, here) == VDM_OK);
        CHECK(vdm_reaction(twin.body, 0, alone) == VDM_OK && same(alone, here, sizeof here) && here[2] != 0);
    }
    CHECK(vdm_batch_get_under(many, body, count) == VDM_STEP && vdm_batch_get_under(many, NULL, 0) == VDM_ARGUMENT);
    CHECK(vdm_batch_get(many, body, count) == VDM_STEP && vdm_batch_set(many, body, 3) == VDM_OK);
    CHECK(vdm_batch_clear(many) == VDM_OK && vdm_batch_carry(many, body) == VDM_OK);
    options.precision = options.precision == VDM_DOUBLE ? VDM_SINGLE : VDM_DOUBLE;
    released(&twin);
    twin = bound(&options);
    CHECK(vdm_batch_get(many, twin.body, 0) == VDM_ARGUMENT);
    printf("batch\n");
    free(memory);
    free(other);
    free(one);
    released(&twin);
    released(&b);
}

/* A free body: thrown, pulled, pushed; at rest where nothing pushes. */
static void flight(struct VdmOptions options) {
    const double up[3] = {0, 0, 3}, spin[3] = {5, 1, 0}, none[3] = {0, 0, 0}, bad[3] = {0, (double)1e308 * 10, 0};
    const double force[3] = {20, 0, 0};
    struct Bound b = bound(&options);
    struct VdmBody *body = b.body;
    struct VdmRigidBody mass;
    struct VdmMotion motion, later, back;
    struct VdmPlace place;
    double at[3], before[3], speed[3], weight[3] = {0, 0, 0}, turned, energy;
    const double step = b.needs.time_step;
    int k;
    CHECK(vdm_at_node(body, b.needs.load_nodes - 1, &place) == VDM_OK);
    if (vdm_flight_mass(body, &mass) != VDM_OK) {
        CHECK(strstr(vdm_message(body), "supports"));
        CHECK(vdm_flight_throw(body, up, spin) == VDM_OUTPUT && vdm_flight_motion(body, &motion) == VDM_OUTPUT);
        CHECK(vdm_flight_ahead(body, &motion) == VDM_OUTPUT && vdm_flight_pull(body, up) == VDM_OUTPUT);
        CHECK(vdm_flight_add_contact(body, &place, up) == VDM_OUTPUT && vdm_flight_step(body) == VDM_OUTPUT);
        CHECK(vdm_flight_add_pattern(body, 0, 1) == VDM_OUTPUT && vdm_flight_point(body, &place, at) == VDM_OUTPUT);
        CHECK(vdm_flight_velocity(body, &place, at) == VDM_OUTPUT);
        memset(&motion, 0, sizeof motion);
        CHECK(vdm_flight_set_motion(body, &motion) == VDM_OUTPUT);
        printf("held\n");
        released(&b);
        return;
    }
    CHECK(mass.mass > 0 && mass.moments[0] > 0 && mass.moments[1] > 0 && mass.moments[2] > 0);
    CHECK(vdm_flight_step(body) == VDM_AT_REST);
    CHECK(vdm_flight_motion(body, &motion) == VDM_OK && same(motion.position, mass.centre, sizeof mass.centre));

    /* Under gravity alone the height is that of the textbook, to the order of the step: it is exact here. */
    CHECK(vdm_flight_throw(body, up, spin) == VDM_OK);
    weight[2] = -9.81 * mass.mass;
    for (k = 0; k < 100; k++) {
        CHECK(vdm_flight_pull(body, weight) == VDM_OK && vdm_flight_ahead(body, &later) == VDM_OK);
        CHECK(vdm_flight_step(body) == VDM_OK && vdm_flight_motion(body, &motion) == VDM_OK);
        CHECK(same(&motion, &later, sizeof motion));
    }
    turned = motion.position[2] - mass.centre[2] - (3 * 100 * step - 0.5 * 9.81 * 100 * step * 100 * step);
    CHECK(turned < 1e-12 && turned > -1e-12);
    CHECK(vdm_energy(body, &energy) == VDM_OK && energy > 0);

    /* The velocity of a place is the rate of where it is. */
    CHECK(vdm_flight_throw(body, none, spin) == VDM_OK && vdm_flight_add_contact(body, &place, force) == VDM_OK);
    CHECK(vdm_flight_step(body) == VDM_OK && vdm_flight_motion(body, &motion) == VDM_OK);
    turned = motion.momentum[0] - 20 * step;
    CHECK(turned < 1e-12 && turned > -1e-12);
    CHECK(vdm_flight_point(body, &place, before) == VDM_OK && vdm_flight_velocity(body, &place, speed) == VDM_OK);
    CHECK(speed[0] * speed[0] + speed[1] * speed[1] + speed[2] * speed[2] > 0);
    CHECK(before[0] != place.position[0] || before[1] != place.position[1]);

    /* Loads that are taken away push nothing; a motion that is set is the one that was read. */
    CHECK(vdm_flight_add_contact(body, &place, force) == VDM_OK && vdm_clear_loads(body) == VDM_OK);
    CHECK(vdm_flight_step(body) == VDM_OK && vdm_flight_motion(body, &later) == VDM_OK);
    CHECK(same(later.momentum, motion.momentum, sizeof motion.momentum));
    for (k = 0; k < 4; k++) motion.attitude[k] *= 2;
    CHECK(vdm_flight_set_motion(body, &motion) == VDM_OK && vdm_flight_motion(body, &back) == VDM_OK);
    CHECK(same(back.position, motion.position, sizeof back.position));
    CHECK(vdm_flight_point(body, &place, at) == VDM_OK);
    CHECK(vdm_rest(body) == VDM_OK && vdm_flight_motion(body, &back) == VDM_OK && back.momentum[0] == 0);

    /* Refusals change nothing. */
    motion.attitude[0] = motion.attitude[1] = motion.attitude[2] = motion.attitude[3] = 0;
    CHECK(vdm_flight_set_motion(body, &motion) == VDM_ARGUMENT && strlen(vdm_message(body)) > 0);
    CHECK(vdm_flight_throw(body, bad, spin) == VDM_ARGUMENT && vdm_flight_throw(body, NULL, spin) == VDM_ARGUMENT);
    CHECK(vdm_flight_add_contact(body, &place, bad) == VDM_LOAD && vdm_flight_pull(body, bad) == VDM_OK);
    CHECK(vdm_flight_step(body) == VDM_STEP && vdm_flight_motion(body, &motion) == VDM_OK);
    CHECK(same(&motion, &back, sizeof back) && vdm_flight_step(body) == VDM_AT_REST);
    CHECK(vdm_flight_add_pattern(body, b.needs.patterns, 1) == VDM_LOAD && vdm_flight_step(NULL) == VDM_ARGUMENT);
    /* The last six patterns are those of the angular velocity, which a step adds itself. */
    CHECK(vdm_flight_add_pattern(body, b.needs.patterns - 1, 1) == VDM_LOAD);
    if (b.needs.patterns > 6) {
        CHECK(vdm_flight_add_pattern(body, 0, 1) == VDM_OK && vdm_flight_step(body) == VDM_OK);
        printf("pattern in flight\n");
    }
    printf("flight\n");
    released(&b);
}

int main(int count, char **arguments) {
    struct VdmBody *body = NULL;
    struct VdmOptions options;
    struct VdmNeeds needs;
    char text[240];
    int structure, precision;
    FILE *source = count == 2 ? fopen(arguments[1], "rb") : NULL;
    CHECK(source);
    file = (uint8_t *)malloc(8000000);
    CHECK(file);
    length = fread(file, 1, 8000000, source);
    fclose(source);
    CHECK(vdm_abi() == VDM_ABI && vdm_verify(file, length, text, sizeof text) == VDM_OK);
    file[length - 1] ^= 1;
    CHECK(vdm_verify(file, length, text, sizeof text) == VDM_FILE && vdm_verify(NULL, 0, NULL, 0) == VDM_ARGUMENT);
    file[length - 1] ^= 1;
    vdm_default_options(&options);
    options.structure = 9;
    CHECK(vdm_measure(file, length, &options, &needs, text, sizeof text) == VDM_ARGUMENT);
    for (structure = VDM_AUTO; structure <= VDM_EXACT; structure++) {
        for (precision = VDM_SINGLE; precision <= VDM_DOUBLE; precision++) {
            vdm_default_options(&options);
            options.structure = structure;
            options.precision = precision;
            if (vdm_measure(file, length, &options, &needs, text, sizeof text) < 0) continue;
            loads(options);
            states(options);
            fields(options);
            live(options);
            batch(options);
            flight(options);
        }
    }
    CHECK(vdm_structure(NULL) == VDM_AUTO && vdm_static_bytes(NULL) == 0 && vdm_modal_march(NULL, 1) == VDM_ARGUMENT);
    free(file);
    return 0;
}
