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
};

static struct Bound bound(const struct VdmOptions *options) {
    char text[240] = "";
    struct Bound b;
    struct VdmBody *body = NULL;
    CHECK(vdm_measure(file, length, options, &b.needs, text, sizeof text) == VDM_OK);
    b.memory = (uint8_t *)malloc(b.needs.memory);
    CHECK(b.memory);
    CHECK(vdm_bind(file, length, options, b.memory, b.needs.memory, &body, text, sizeof text) == VDM_OK);
    b.body = body;
    return b;
}

static enum VdmStatus rebound(struct Bound *b, const struct VdmOptions *options) {
    return vdm_bind(file, length, options, b->memory, b->needs.memory, &b->body, NULL, 0);
}

static void released(struct Bound *b) {
    free(b->memory);
}

/* A saved state, in memory of the exact length. */
struct Saved {
    uint8_t *bytes;
    size_t length;
};

static struct Saved saved(struct VdmBody *body) {
    struct Saved s;
    const size_t most = vdm_saved_length(body);
    CHECK(most >= 16);
    s.bytes = (uint8_t *)malloc(most);
    s.length = 0;
    CHECK(s.bytes && vdm_save(body, s.bytes, most, &s.length) == VDM_OK && s.length > 16 && s.length <= most);
    return s;
}

static int same(const void *a, const void *b, size_t bytes) {
    return memcmp(a, b, bytes) == 0;
}

/* Whether two states are the same; both are released. */
static int equal(struct Saved *a, struct Saved *b) {
    const int found = a->length == b->length && same(a->bytes, b->bytes, a->length);
    free(a->bytes);
    free(b->bytes);
    return found;
}

/* Loads that change within a step, kept loads, and places that are nodes. */
static void loads(struct VdmOptions options) {
    struct Bound b;
    struct VdmBody *body = NULL;
    struct VdmPlace place, other_place;
    double at[4], held[3] = {1.0, -2.0, -20.0}, none[3] = {0, 0, 0}, half[3], moved[3], other[3], amplitudes[4];
    struct Saved one, other_one;
    uint32_t node;
    int k;
    options.keep_loads = 1;
    options.flight = 0;
    b = bound(&options);
    body = b.body;
    node = b.needs.load_nodes - 1;
    CHECK(vdm_instants(body, at) == VDM_OK && at[0] == 0.0 && at[1] > 0.0 && at[1] <= 1.0);
    CHECK(vdm_at_node(body, b.needs.load_nodes, &place) == VDM_LOAD);
    CHECK(vdm_at_node(body, b.needs.load_nodes - 1, &place) == VDM_OK && place.count == 1 && place.weights[0] == 1.0 && place.nodes[0] == node &&
          place.frame == VDM_NO_FRAME && place.radius == 0.0);

    /* A place that is a list of nodes; what is no place is refused. */
    other_place = place;
    other_place.count = 4;
    for (k = 0; k < 4; k++) {
        other_place.nodes[k] = node;
        other_place.weights[k] = 0.25;
    }
    CHECK(vdm_push(body, &other_place, held) == VDM_OK && vdm_clear(body) == VDM_OK);
    other_place.weights[0] = 0.5;
    CHECK(vdm_push(body, &other_place, held) == VDM_LOAD && strstr(vdm_message(body), "sum"));
    other_place.weights[0] = 0.25;
    other_place.radius = 1e-3;
    CHECK(vdm_push(body, &other_place, held) == VDM_LOAD && strstr(vdm_message(body), "radius"));
    other_place = place;
    other_place.frame = 0;
    CHECK(vdm_push(body, &other_place, held) == VDM_LOAD && strstr(vdm_message(body), "frame"));
    other_place = place;
    other_place.count = VDM_MAX_PLACE_NODES + 1;
    CHECK(vdm_push(body, &other_place, held) == VDM_LOAD && vdm_point(body, &other_place, 0, half) == VDM_OUTPUT);
    CHECK(vdm_push(body, NULL, held) == VDM_ARGUMENT && strstr(vdm_message(body), "`place`"));

    /* A ramp between two equal forces is a held force, to rounding; half of one, a force of half the size. */
    CHECK(vdm_push(body, &place, held) == VDM_OK && vdm_keep_loads(body) == VDM_OK);
    CHECK(vdm_step(body, 3) == VDM_OK && vdm_node(body, node, VDM_DISPLACEMENT, moved) == VDM_OK);
    CHECK(vdm_rest(body) == VDM_OK && vdm_clear(body) == VDM_OK);
    CHECK(vdm_push_ramp(body, &place, held, held) == VDM_OK && vdm_step(body, 3) == VDM_OK);
    CHECK(vdm_node(body, node, VDM_DISPLACEMENT, other) == VDM_OK);
    for (k = 0; k < 3; k++) CHECK(other[k] - moved[k] <= 1e-9 && moved[k] - other[k] <= 1e-9);
    CHECK(moved[2] < 0);
    CHECK(vdm_rest(body) == VDM_OK && vdm_recall_loads(body) == VDM_OK && vdm_step(body, 3) == VDM_OK);
    CHECK(vdm_node(body, node, VDM_DISPLACEMENT, other) == VDM_OK && same(moved, other, sizeof moved));

    /* A force that rises, as a ramp and by its amplitudes: the same bits. */
    CHECK(vdm_rest(body) == VDM_OK && vdm_clear(body) == VDM_OK);
    CHECK(vdm_push_staged(body, &place, held, at) == VDM_OK && vdm_step(body, 1) == VDM_OK);
    one = saved(body);
    CHECK(vdm_rest(body) == VDM_OK && vdm_clear(body) == VDM_OK);
    CHECK(vdm_push_ramp(body, &place, none, held) == VDM_OK && vdm_step(body, 1) == VDM_OK);
    other_one = saved(body);
    CHECK(equal(&one, &other_one));
    half[0] = half[1] = half[2] = (double)1e308 * 10;
    CHECK(vdm_push_ramp(body, &place, none, half) == VDM_LOAD);
    amplitudes[0] = amplitudes[1] = amplitudes[2] = amplitudes[3] = half[0];
    CHECK(vdm_push_staged(body, &place, held, amplitudes) == VDM_LOAD);
    printf("loads\n");

    if (b.needs.patterns > 0) {
        CHECK(vdm_rest(body) == VDM_OK && vdm_clear(body) == VDM_OK);
        CHECK(vdm_push_pattern_ramp(body, 0, 0.0, 1.0) == VDM_OK && vdm_step(body, 1) == VDM_OK);
        one = saved(body);
        CHECK(vdm_rest(body) == VDM_OK && vdm_clear(body) == VDM_OK);
        CHECK(vdm_push_pattern_staged(body, 0, at) == VDM_OK && vdm_step(body, 1) == VDM_OK);
        other_one = saved(body);
        CHECK(equal(&one, &other_one));
        CHECK(vdm_push_pattern_staged(body, b.needs.patterns, at) == VDM_LOAD);
        printf("patterns\n");
    }
    if (vdm_stress_points(body) > 0) {
        uint32_t where[2] = {99, 99};
        double stress[6], strain[6], equivalent = 0;
        CHECK(vdm_rest(body) == VDM_OK && vdm_clear(body) == VDM_OK);
        CHECK(vdm_push(body, &place, held) == VDM_OK && vdm_step(body, 1) == VDM_OK);
        CHECK(vdm_stress_point(body, 0, where) == VDM_OK && where[0] < 99 && where[1] < 99);
        CHECK(vdm_stress(body, 0, stress) == VDM_OK && vdm_von_mises(body, 0, &equivalent) == VDM_OK && equivalent > 0);
        CHECK(vdm_strain(body, 0, strain) == VDM_OK && strain[3] * stress[3] > 0);
        CHECK(vdm_stress(body, vdm_stress_points(body), stress) == VDM_OUTPUT);
        CHECK(vdm_stress(NULL, 0, stress) == VDM_ARGUMENT && vdm_strain(body, 0, NULL) == VDM_ARGUMENT);
        CHECK(vdm_stress_points(NULL) == 0 && vdm_stress_point(body, 1u << 20, where) == VDM_OUTPUT);
        CHECK(vdm_von_mises(body, 0, NULL) == VDM_ARGUMENT && vdm_von_mises(NULL, 0, &equivalent) == VDM_ARGUMENT);
        printf("stress\n");
    }
    if (vdm_find(body, VDM_SUPPORTS, "left") == 0) {
        double exerted[6] = {0, 0, 0, 0, 0, 0};
        CHECK(vdm_rest(body) == VDM_OK && vdm_clear(body) == VDM_OK);
        CHECK(vdm_push(body, &place, held) == VDM_OK && vdm_step(body, 1) == VDM_OK);
        CHECK(vdm_reaction(body, 0, exerted) == VDM_OK && exerted[2] != 0);
        CHECK(vdm_reaction(body, 99, exerted) == VDM_OUTPUT && vdm_reaction(body, 0, NULL) == VDM_ARGUMENT);
        printf("reactions\n");
    }
    CHECK(vdm_rest(body) == VDM_OK && vdm_clear(body) == VDM_OK);
    CHECK(vdm_push_base(body, held, none, NULL) == VDM_ARGUMENT);
    if (vdm_find(body, VDM_PATTERNS, "base.ax") >= 0) {
        CHECK(vdm_push_base(body, held, none, none) == VDM_OK && vdm_step(body, 1) == VDM_OK);
        CHECK(vdm_node(body, node, VDM_DISPLACEMENT, moved) == VDM_OK && moved[2] != 0);
        CHECK(vdm_push_base(body, none, half, none) == VDM_LOAD);
        printf("base\n");
    } else {
        CHECK(vdm_push_base(body, held, none, none) == VDM_LOAD);
    }
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
    struct Saved one;
    size_t written;
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
    CHECK(vdm_coordinates(body, read, speed, 0) == VDM_OUTPUT);
    CHECK(vdm_cost(body, &cost) == VDM_OK && cost.step_operations > 0 && cost.step_bytes > 0);
    CHECK(vdm_increment(body, map, rows * rows) == (strain ? VDM_OUTPUT : VDM_OK));
    CHECK(vdm_increment(body, map, 1) == VDM_OUTPUT);
    CHECK(vdm_energy_at_rest(body, &rest) == VDM_OK && rest >= 0);
    one = saved(body);
    CHECK(vdm_save(body, one.bytes, 15, &written) == VDM_STATE && vdm_save(body, NULL, 99, &written) == VDM_ARGUMENT);
    CHECK(strstr(vdm_message(body), "`bytes`") && vdm_saved_length(NULL) == 0);
    CHECK(vdm_restore(body, one.bytes, one.length) == VDM_OK);
    CHECK(vdm_restore(body, one.bytes, one.length - 1) == VDM_STATE && strlen(vdm_message(body)) > 0);
    one.bytes[0] ^= 1;
    CHECK(vdm_restore(body, one.bytes, one.length) == VDM_STATE);
    one.bytes[0] ^= 1;
    one.bytes[4] ^= 1;
    CHECK(vdm_restore(body, one.bytes, one.length) == VDM_STATE && strstr(vdm_message(body), "another file"));
    one.bytes[4] ^= 1;

    /* Another body of the same file, with half the step where it allows one. */
    if (vdm_structure(body) != VDM_BLOCK) options.time_step = 0.5 * b.needs.time_step;
    other = bound(&options);
    CHECK(vdm_restore(other.body, one.bytes, one.length) ==
          (other.needs.time_step == b.needs.time_step ? VDM_OK : VDM_CARRIED));
    free(one.bytes);
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
        CHECK(vdm_push(body, &place, force) == VDM_OK && vdm_step(body, 1) == VDM_OK);
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
    CHECK(at && wide && plain && nodes && narrow);
    CHECK(vdm_at_node(body, b.needs.load_nodes - 1, &place) == VDM_OK);
    CHECK(vdm_positions(body, at, surface + 1) == VDM_OUTPUT && vdm_triangles(body, nodes, 1) == VDM_OUTPUT);
    if (vdm_positions(body, at, surface) == VDM_OK) {
        CHECK(vdm_triangles(body, nodes, 3 * (size_t)b.needs.triangles) == VDM_OK);
        for (k = 0; k < 3 * b.needs.triangles; k++) CHECK(nodes[k] < b.needs.surface_nodes);
        CHECK(place.position[0] == at[3 * place.nodes[0]] && place.position[2] == at[3 * place.nodes[0] + 2]);
        uint32_t vertices = 1, triangles = 1;
        CHECK(vdm_embedded_sizes(body, &vertices, &triangles) == VDM_OK);
        if (triangles == 0) {
            CHECK(vertices == 0 && vdm_embedded_triangles(body, nodes, 0) == VDM_OUTPUT);
            CHECK(vdm_embedded_interpolate(body, at, surface, plain, 0) == VDM_OUTPUT);
        } else if (3 * (size_t)vertices <= all) {
            CHECK(vdm_embedded_triangles(body, nodes, 3 * (size_t)triangles) == VDM_OK);
            CHECK(vdm_embedded_interpolate(body, at, surface, plain, 3 * (size_t)vertices) == VDM_OK);
            CHECK(vdm_embedded_interpolate(body, at, surface, plain, 3 * (size_t)vertices + 1) == VDM_OUTPUT);
            CHECK(vdm_embedded_interpolate(body, at, 3, plain, 3 * (size_t)vertices) == VDM_OUTPUT);
            for (k = 0; k < 3 * vertices; k++) CHECK(plain[k] - plain[k] == 0);
            printf("embedded\n");
        }
        printf("shape\n");
    }
    CHECK(vdm_push(body, &place, force) == VDM_OK && vdm_step(body, 20) == VDM_OK);
    if (options.precision == VDM_DOUBLE) {
        CHECK(vdm_surface_f64(body, VDM_VELOCITY, wide, surface) == VDM_OK);
        CHECK(vdm_surface_f32(body, VDM_VELOCITY, narrow, surface) == VDM_ARGUMENT);
        CHECK(vdm_whole_f32(body, VDM_VELOCITY, narrow, all) == VDM_ARGUMENT);
        if (vdm_whole_f64(body, VDM_VELOCITY, plain, all) == VDM_OK) {
            CHECK(same(wide, plain, surface * sizeof(double)));
            printf("body\n");
        }
    } else {
        CHECK(vdm_surface_f32(body, VDM_VELOCITY, narrow, surface) == VDM_OK);
        CHECK(vdm_surface_f64(body, VDM_VELOCITY, wide, surface) == VDM_ARGUMENT);
        CHECK(vdm_whole_f64(body, VDM_VELOCITY, wide, all) == VDM_ARGUMENT);
        CHECK(vdm_whole_f32(body, 5, narrow, all) == VDM_ARGUMENT);
        CHECK(vdm_whole_with_statics_f64(body, VDM_VELOCITY, wide, all) == VDM_ARGUMENT);
    }
    printf("fields\n");

    CHECK(vdm_solve_statics(body) == VDM_OUTPUT && strstr(vdm_message(body), "static_field"));
    CHECK(vdm_surface_with_statics_f32(body, VDM_DISPLACEMENT, narrow, surface) < 0);
    CHECK(vdm_surface_with_statics_f64(body, VDM_DISPLACEMENT, wide, surface) < 0);
    released(&b);
    options.static_field = 1;
    b = bound(&options);
    body = b.body;
    CHECK(vdm_push(body, &place, force) == VDM_OK && vdm_step(body, 20) == VDM_OK);
    if (vdm_solve_statics(body) == VDM_OK && options.precision == VDM_DOUBLE) {
        double largest = 0;
        CHECK(vdm_whole_with_statics_f64(body, VDM_DISPLACEMENT, wide, all) == VDM_OK);
        CHECK(vdm_whole_f64(body, VDM_DISPLACEMENT, plain, all) == VDM_OK);
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
        CHECK(vdm_surface_with_statics_f64(body, VDM_DISPLACEMENT, plain, surface) == VDM_OK);
        CHECK(same(plain, wide, surface * sizeof(double)));
        printf("statics\n");
    }
    free(narrow);
    free(nodes);
    free(plain);
    free(wide);
    free(at);
    released(&b);
}

/* Live parameters. */
static void live(struct VdmOptions options) {
    struct Bound b = bound(&options);
    struct VdmBody *body = b.body;
    struct VdmParameter one;
    const size_t count = b.needs.parameters;
    struct VdmCarried carried;
    struct VdmBatch *many = NULL;
    const size_t bytes = vdm_batch_bytes(body, 1);
    uint8_t *memory = (uint8_t *)malloc(bytes);
    const int regions = vdm_carried(body, &carried) == VDM_OK;
    double *values = (double *)malloc((count + 1) * sizeof(double));
    uint32_t *ids = (uint32_t *)malloc((count + 1) * sizeof(uint32_t)), k;
    CHECK(memory && vdm_batch_bind(body, 1, memory, bytes, &many) == VDM_OK);
    CHECK(values && ids && vdm_parameter(body, b.needs.parameters, &one) == VDM_ARGUMENT);
    for (k = 0; k < count; k++) {
        CHECK(vdm_parameter(body, k, &one) == VDM_OK && one.lower <= one.value && one.value <= one.upper);
        ids[k] = k;
        values[k] = 0.75 * one.nominal + 0.25 * one.upper;
        printf("parameter\n");
    }
    ids[count] = b.needs.parameters;
    values[count] = 1;
    CHECK(vdm_set_parameters(body, ids, values, count + 1) == VDM_BIND && strlen(vdm_message(body)) > 0);
    CHECK(vdm_set_parameters(body, NULL, values, 1) == VDM_ARGUMENT && strstr(vdm_message(body), "`ids`"));
    CHECK(vdm_set_parameters(body, NULL, NULL, 0) == VDM_OK);
    if (count > 0) {
        CHECK(vdm_set_parameters(body, ids, values, count) == VDM_OK);
        CHECK(vdm_parameter(body, 0, &one) == VDM_OK && one.value == values[0]);
        ids[count] = 0;
        values[count] = one.nominal;
        CHECK(vdm_set_parameters(body, ids, values, count + 1) == VDM_BIND && strstr(vdm_message(body), "twice"));
        values[0] = one.upper * 2;
        CHECK(vdm_set_parameters(body, ids, values, 1) == VDM_BIND);
        CHECK(vdm_parameter(body, 0, &one) == VDM_OK && one.value != values[0]);
        CHECK(vdm_batch_carry(many, body) == (regions ? VDM_BIND : VDM_OK));
        CHECK(!regions || strstr(vdm_message(body), "another batch"));
    }
    CHECK(vdm_carried(body, NULL) == VDM_ARGUMENT);
    CHECK(vdm_carried(body, &carried) == (regions ? VDM_OK : VDM_OUTPUT));
    if (regions) {
        /* Stepped modes are a choice of who binds. */
        struct Bound fewer;
        options.modes = 2;
        fewer = bound(&options);
        CHECK(fewer.needs.modes == 2 && fewer.needs.memory < b.needs.memory);
        options.modes = 1000;
        CHECK(rebound(&fewer, &options) == VDM_BIND);
        released(&fewer);
        printf("stepped modes\n");
    }
    free(memory);
    free(ids);
    free(values);
    released(&b);
}

/* The table of quantities: each that the body has can be read. */
static void quantities(struct VdmOptions options) {
    const double force[3] = {1, 2, -10};
    struct Bound b = bound(&options);
    struct VdmBody *body = b.body;
    struct VdmPlace place;
    struct VdmQuantity row;
    double *numbers = (double *)malloc((3 * (size_t)b.needs.nodes + 8) * sizeof(double)), energy, parts = 0;
    uint32_t q;
    CHECK(numbers && vdm_at_node(body, b.needs.load_nodes - 1, &place) == VDM_OK);
    CHECK(vdm_push(body, &place, force) == VDM_OK && vdm_step(body, 5) == VDM_OK);
    CHECK(vdm_energy(body, &energy) == VDM_OK && energy > 0);
    for (q = 0; vdm_quantity(q, &row) == VDM_OK; q++) {
        const size_t length = vdm_length(body, q);
        CHECK(strlen(row.name) > 0 && strlen(row.unit) > 0 && vdm_find_quantity(row.name) == (int32_t)q);
        CHECK((row.scalar != 0) == (length == 1));
        if (strcmp(row.name, "point") == 0 || vdm_count(body, q) == 0) continue;
        if (vdm_structure(body) == VDM_STRAIN && !row.scalar && !*row.rate_unit) continue;
        CHECK(vdm_read(body, q, 0, VDM_DISPLACEMENT, numbers, length) == VDM_OK);
        if (strcmp(row.unit, "J") == 0) parts += numbers[0];
        CHECK(vdm_read(body, q, 0, VDM_VELOCITY, numbers, length) == (*row.rate_unit ? VDM_OK : VDM_OUTPUT));
        CHECK(vdm_read(body, q, 0, VDM_DISPLACEMENT, numbers, length + 1) == VDM_OUTPUT);
        CHECK(vdm_read(body, q, vdm_count(body, q), VDM_DISPLACEMENT, numbers, length) == VDM_OUTPUT);
    }
    /* The energy, and its parts. */
    CHECK(q >= 17 && parts - 2 * energy < 1e-12 * energy && 2 * energy - parts < 1e-12 * energy);
    CHECK(vdm_find_quantity("heat") == -1 && vdm_find_quantity(NULL) == -1 && vdm_quantity(0, NULL) == VDM_ARGUMENT);
    CHECK(vdm_read(body, q, 0, VDM_DISPLACEMENT, numbers, 1) == VDM_ARGUMENT && vdm_count(NULL, 0) == 0);
    printf("quantities\n");
    free(numbers);
    released(&b);
}

/* Many instances have the bits of one. */
static void batch(struct VdmOptions options) {
    struct Saved one, other_one;
    const size_t count = 21;
    struct Bound b, twin;
    struct VdmBody *body = NULL;
    struct VdmBatch *many = NULL;
    struct VdmBatchStatus found;
    struct VdmPlace place;
    size_t bytes, k;
    uint8_t *memory;
    /* The host moves the instances, so their loads stay. */
    options.flight = 0;
    b = bound(&options);
    body = b.body;
    bytes = vdm_batch_bytes(body, count);
    memory = (uint8_t *)malloc(bytes);
    CHECK(memory && vdm_batch_bytes(NULL, 1) == 0 && vdm_batch_bytes(body, (size_t)-1) == (size_t)-1);
    CHECK(vdm_batch_bind(body, count, memory, bytes - 1, &many) == VDM_MEMORY && !many);
    CHECK(vdm_batch_bind(body, count, NULL, bytes, &many) == VDM_MEMORY && !many);
    CHECK(vdm_batch_bind(body, count, memory, bytes, &many) == VDM_OK && many);
    CHECK(vdm_batch_step(many, body, 1, &found) == VDM_AT_REST && found.at_rest == count);
    CHECK(vdm_batch_load(many, NULL, 0) == VDM_ARGUMENT && vdm_batch_load(NULL, body, 0) == VDM_ARGUMENT);
    CHECK(vdm_at_node(body, b.needs.load_nodes - 1, &place) == VDM_OK);
    for (k = 0; k < count; k++) {
        const double force[3] = {0, 1, -(double)k};
        CHECK(vdm_clear(body) == VDM_OK && vdm_push(body, &place, force) == VDM_OK);
        CHECK(vdm_batch_load(many, body, k) == VDM_OK);
    }
    CHECK(vdm_batch_load(many, body, count) == VDM_LOAD);
    CHECK(vdm_batch_step(many, body, 7, &found) == VDM_OK && found.moving == count && found.refused == 0);
    twin = bound(&options);
    {
        const double force[3] = {0, 1, -20};
        /* The batch has made a step at rest before. */
        CHECK(vdm_step(twin.body, 1) == VDM_AT_REST);
        CHECK(vdm_push(twin.body, &place, force) == VDM_OK && vdm_step(twin.body, 7) == VDM_OK);
    }
    CHECK(vdm_batch_status(many, body, 20) == VDM_OK && vdm_batch_status(many, body, count) == VDM_STEP);
    CHECK(vdm_batch_get_under(many, body, 20) == VDM_OK);
    one = saved(body);
    other_one = saved(twin.body);
    CHECK(equal(&one, &other_one));
    CHECK(vdm_batch_get(many, body, 20) == VDM_OK);
    if (vdm_find(body, VDM_SUPPORTS, "left") == 0) {
        double alone[6], here[6];
        CHECK(vdm_reaction(body, 0, here) == VDM_OUTPUT && strstr(vdm_message(body), "not remembered"));
        CHECK(vdm_batch_get_under(many, body, 20) == VDM_OK && vdm_reaction(body, 0, here) == VDM_OK);
        CHECK(vdm_reaction(twin.body, 0, alone) == VDM_OK && same(alone, here, sizeof here) && here[2] != 0);
    }
    CHECK(vdm_batch_get_under(many, body, count) == VDM_STEP && vdm_batch_get_under(many, NULL, 0) == VDM_ARGUMENT &&
          vdm_batch_get_under(NULL, body, 0) == VDM_ARGUMENT && strstr(vdm_message(body), "`batch`"));
    CHECK(vdm_batch_get(many, body, count) == VDM_STEP && vdm_batch_set(many, body, 3) == VDM_OK);
    CHECK(vdm_batch_clear(many) == VDM_OK && vdm_batch_carry(many, body) == VDM_OK);
    options.precision = options.precision == VDM_DOUBLE ? VDM_SINGLE : VDM_DOUBLE;
    released(&twin);
    twin = bound(&options);
    CHECK(vdm_batch_get(many, twin.body, 0) == VDM_ARGUMENT);
    printf("batch\n");
    free(memory);
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
    if (vdm_rigid_body(body, &mass) != VDM_OK) {
        CHECK(strstr(vdm_message(body), "supports"));
        CHECK(vdm_throw(body, up, spin) == VDM_OUTPUT && vdm_motion(body, &motion) == VDM_OUTPUT);
        CHECK(vdm_ahead(body, &motion) == VDM_OUTPUT && vdm_pull(body, up) == VDM_OUTPUT);
        CHECK(vdm_in_space(body, &place, VDM_DISPLACEMENT, at) == VDM_OUTPUT && vdm_push_spin(body, none, spin) == VDM_LOAD);
        CHECK(vdm_in_space(body, &place, VDM_VELOCITY, at) == VDM_OUTPUT);
        memset(&motion, 0, sizeof motion);
        CHECK(vdm_set_motion(body, &motion) == VDM_OUTPUT);
        printf("held\n");
        released(&b);
        return;
    }
    CHECK(mass.mass > 0 && mass.moments[0] > 0 && mass.moments[1] > 0 && mass.moments[2] > 0);
    CHECK(vdm_step(body, 1) == VDM_AT_REST);
    CHECK(vdm_motion(body, &motion) == VDM_OK && same(motion.position, mass.centre, sizeof mass.centre));

    /* Under gravity alone the height is that of the textbook, to the order of the step: it is exact here. */
    CHECK(vdm_throw(body, up, spin) == VDM_OK);
    weight[2] = -9.81 * mass.mass;
    for (k = 0; k < 100; k++) {
        CHECK(vdm_pull(body, weight) == VDM_OK && vdm_ahead(body, &later) == VDM_OK);
        CHECK(vdm_step(body, 1) == VDM_OK && vdm_motion(body, &motion) == VDM_OK);
        CHECK(same(&motion, &later, sizeof motion));
    }
    turned = motion.position[2] - mass.centre[2] - (3 * 100 * step - 0.5 * 9.81 * 100 * step * 100 * step);
    CHECK(turned < 1e-12 && turned > -1e-12);
    CHECK(vdm_energy(body, &energy) == VDM_OK && energy > 0);

    /* The velocity of a place is the rate of where it is. */
    CHECK(vdm_throw(body, none, spin) == VDM_OK && vdm_push(body, &place, force) == VDM_OK);
    CHECK(vdm_step(body, 1) == VDM_OK && vdm_motion(body, &motion) == VDM_OK);
    turned = motion.momentum[0] - 20 * step;
    CHECK(turned < 1e-12 && turned > -1e-12);
    CHECK(vdm_in_space(body, &place, VDM_DISPLACEMENT, before) == VDM_OK && vdm_in_space(body, &place, VDM_VELOCITY, speed) == VDM_OK);
    CHECK(speed[0] * speed[0] + speed[1] * speed[1] + speed[2] * speed[2] > 0);
    CHECK(before[0] != place.position[0] || before[1] != place.position[1]);

    /* Loads that are taken away push nothing; a motion that is set is the one that was read. */
    CHECK(vdm_push(body, &place, force) == VDM_OK && vdm_clear(body) == VDM_OK);
    CHECK(vdm_step(body, 1) == VDM_OK && vdm_motion(body, &later) == VDM_OK);
    CHECK(same(later.momentum, motion.momentum, sizeof motion.momentum));
    for (k = 0; k < 4; k++) motion.attitude[k] *= 2;
    CHECK(vdm_set_motion(body, &motion) == VDM_OK && vdm_motion(body, &back) == VDM_OK);
    CHECK(same(back.position, motion.position, sizeof back.position));
    CHECK(vdm_in_space(body, &place, VDM_DISPLACEMENT, at) == VDM_OK);
    CHECK(vdm_rest(body) == VDM_OK && vdm_motion(body, &back) == VDM_OK && back.momentum[0] == 0);

    /* Refusals change nothing. */
    motion.attitude[0] = motion.attitude[1] = motion.attitude[2] = motion.attitude[3] = 0;
    CHECK(vdm_set_motion(body, &motion) == VDM_ARGUMENT && strlen(vdm_message(body)) > 0);
    CHECK(vdm_throw(body, bad, spin) == VDM_ARGUMENT && vdm_throw(body, NULL, spin) == VDM_ARGUMENT);
    CHECK(vdm_push(body, &place, bad) == VDM_LOAD && vdm_pull(body, bad) == VDM_OK);
    CHECK(vdm_step(body, 1) == VDM_STEP && vdm_motion(body, &motion) == VDM_OK);
    CHECK(same(&motion, &back, sizeof back) && vdm_step(body, 1) == VDM_AT_REST);
    CHECK(vdm_push_pattern(body, b.needs.patterns, 1) == VDM_LOAD && vdm_step(NULL, 1) == VDM_ARGUMENT);
    /* The last six patterns are those of the angular velocity, which a step adds itself. */
    CHECK(vdm_push_pattern(body, b.needs.patterns - 1, 1) == VDM_LOAD);
    if (b.needs.patterns > 6) {
        CHECK(vdm_push_pattern(body, 0, 1) == VDM_OK && vdm_step(body, 1) == VDM_OK);
        printf("pattern in flight\n");
    }
    printf("flight\n");
    released(&b);

    /* A host that moves the body: loads stay, and the frame does not move. */
    options.flight = 0;
    b = bound(&options);
    body = b.body;
    CHECK(vdm_pull(body, up) == VDM_OUTPUT && strstr(vdm_message(body), "flight"));
    CHECK(vdm_throw(body, up, spin) == VDM_OUTPUT && vdm_rigid_body(body, &mass) == VDM_OK);
    CHECK(vdm_push_spin(body, none, spin) == VDM_OK && vdm_step(body, 2) == VDM_OK);
    CHECK(vdm_energy(body, &energy) == VDM_OK && energy > 0);
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
            quantities(options);
            batch(options);
            flight(options);
        }
    }
    CHECK(vdm_structure(NULL) == VDM_AUTO && vdm_push(NULL, NULL, NULL) == VDM_ARGUMENT && *vdm_message(NULL));
    free(file);
    return 0;
}
