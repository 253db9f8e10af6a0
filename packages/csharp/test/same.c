/* The march of Same.cs in C: each number as its bits. check compares what the two print. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vademecum.h"

static void bits(const char *what, const double *values, size_t count) {
    size_t i;
    printf("%s", what);
    for (i = 0; i < count; i++) {
        uint64_t raw;
        memcpy(&raw, values + i, 8);
        printf(" %016" PRIx64, raw);
    }
    printf("\n");
}

/* Of bytes: their number, and FNV-1a of them. */
static void hashed(const char *what, const uint8_t *bytes, size_t count) {
    uint64_t hash = 14695981039346656037u;
    size_t i;
    for (i = 0; i < count; i++) hash = (hash ^ bytes[i]) * 1099511628211u;
    printf("%s %zu %016" PRIx64 "\n", what, count, hash);
}

static int refused(struct VdmBody *body, const char *what, int status) {
    if (status < 0) printf("%s refused %d: %s\n", what, status, vdm_message(body));
    return status < 0;
}

static uint8_t *file_of(const char *path, size_t *length) {
    uint8_t *bytes = malloc(100000000);
    FILE *source = fopen(path, "rb");
    if (!source || !bytes) exit(1);
    *length = fread(bytes, 1, 100000000, source);
    fclose(source);
    return bytes;
}

static void read_all(struct VdmBody *body, const struct VdmNeeds *needs, const struct VdmPlace *place, int precision) {
    double v[9];
    uint32_t i, pair[2];
    size_t written = 0;
    if (!refused(body, "point", vdm_point(body, place, VDM_DISPLACEMENT, v))) bits("point", v, 3);
    if (!refused(body, "speed", vdm_point(body, place, VDM_VELOCITY, v))) bits("speed", v, 3);
    if (!refused(body, "node", vdm_node(body, needs->nodes - 1, VDM_DISPLACEMENT, v))) bits("node", v, 3);
    if (!refused(body, "energy", vdm_energy(body, v))) bits("energy", v, 1);
    for (i = 0; i < needs->probes; i++)
        if (!refused(body, "probe", vdm_probe(body, i, VDM_DISPLACEMENT, v))) bits("probe", v, 1);
    for (i = 0; i < 2; i++)
        if (!refused(body, "reaction", vdm_reaction(body, i, v))) bits("reaction", v, 6);
    printf("stress points %u\n", vdm_stress_points(body));
    for (i = 0; i < vdm_stress_points(body); i++) {
        if (!refused(body, "where", vdm_stress_point(body, i, pair))) printf("where %u %u\n", pair[0], pair[1]);
        if (!refused(body, "stress", vdm_stress(body, i, v))) bits("stress", v, 6);
        if (!refused(body, "strain", vdm_strain(body, i, v))) bits("strain", v, 6);
        if (!refused(body, "mises", vdm_von_mises(body, i, v))) bits("mises", v, 1);
    }
    {
        double *surface = malloc(3 * needs->surface_nodes * sizeof *surface);
        float *single = malloc(3 * needs->surface_nodes * sizeof *single);
        int status = precision == VDM_DOUBLE ? vdm_surface_f64(body, VDM_DISPLACEMENT, surface, 3 * needs->surface_nodes)
                                             : vdm_surface_f32(body, VDM_DISPLACEMENT, single, 3 * needs->surface_nodes);
        if (!refused(body, "surface", status)) {
            if (precision == VDM_SINGLE)
                for (i = 0; i < 3 * needs->surface_nodes; i++) surface[i] = single[i];
            bits("surface", surface, 3 * needs->surface_nodes);
        }
        free(surface);
        free(single);
    }
    {
        double *zeta = malloc(2 * needs->modes * sizeof *zeta);
        if (!refused(body, "coordinates", vdm_coordinates(body, zeta, zeta + needs->modes, needs->modes)))
            bits("coordinates", zeta, 2 * needs->modes);
        free(zeta);
    }
    {
        size_t capacity = vdm_saved_length(body);
        uint8_t *bytes = malloc(capacity);
        if (!refused(body, "save", vdm_save(body, bytes, capacity, &written))) hashed("save", bytes, written);
        free(bytes);
    }
}

static void march(const char *path, const char *name, int precision) {
    const double push[3] = {1.0, -2.0, 3.0}, end[3] = {-0.5, 0.25, 0.125};
    double w[36], u[6];
    char text[1024];
    size_t length;
    uint8_t *file = file_of(path, &length);
    void *memory;
    struct VdmNeeds needs;
    struct VdmOptions options;
    struct VdmBody *body;
    struct VdmPlace places[2];
    uint32_t i;
    int status;
    printf("== %s %d\n", name, precision);
    vdm_default_options(&options);
    options.precision = precision;
    options.places = 2;
    options.flight = 0;
    status = vdm_measure(file, length, &options, &needs, text, sizeof text);
    if (status < 0) {
        printf("measure refused %d: %s\n", status, text);
        return;
    }
    memory = aligned_alloc(16, (needs.memory + 15) / 16 * 16);
    status = vdm_bind(file, length, &options, memory, needs.memory, &body, text, sizeof text);
    if (status < 0) {
        printf("bind refused %d: %s\n", status, text);
        return;
    }
    printf("needs %zu %u %u %u %u %u %u %u %u %u\n", needs.memory, needs.modes, needs.nodes, needs.surface_nodes, needs.load_nodes,
           needs.triangles, needs.load_triangles, needs.probes, needs.patterns, needs.parameters);
    bits("step", &needs.time_step, 1);
    for (i = 0; i < 2; i++)
        if (refused(body, "place", vdm_at_node(body, 1 + i, &places[i]))) return;
    bits("place", places[1].position, 3);
    refused(body, "push", vdm_push(body, &places[0], push));
    refused(body, "step", vdm_step(body, 20));
    refused(body, "ramp", vdm_push_ramp(body, &places[1], push, end));
    refused(body, "pattern", vdm_push_pattern(body, 0, 0.5));
    if (!refused(body, "compliance", vdm_compliance(body, places, 2, w))) bits("compliance", w, 36);
    if (!refused(body, "free", vdm_free_motion(body, places, 2, u))) bits("free", u, 6);
    refused(body, "step", vdm_step(body, 1));
    read_all(body, &needs, &places[0], precision);
    refused(body, "clear", vdm_clear(body));
    for (i = 0; i < needs.parameters; i++) {
        struct VdmParameter found;
        double value;
        refused(body, "parameter", vdm_parameter(body, i, &found));
        value = found.lower + 0.375 * (found.upper - found.lower);
        printf("parameter %u\n", found.logarithmic);
        bits("range", &found.lower, 4);
        refused(body, "set", vdm_set_parameters(body, &i, &value, 1));
    }
    refused(body, "nowhere", vdm_push_pattern(body, 77, 1.0));
    refused(body, "push", vdm_push(body, &places[1], push));
    refused(body, "step", vdm_step(body, 10));
    read_all(body, &needs, &places[1], precision);
    free(memory);
    free(file);
}

static struct VdmBody *member(const char *path) {
    char text[1024];
    size_t length;
    uint8_t *file = file_of(path, &length);
    struct VdmNeeds needs;
    struct VdmOptions options;
    struct VdmBody *body = NULL;
    vdm_default_options(&options);
    options.contacts = 128;
    options.time_step = 1e-3;
    if (vdm_measure(file, length, &options, &needs, text, sizeof text) < 0) exit(1);
    vdm_bind(file, length, &options, aligned_alloc(16, (needs.memory + 15) / 16 * 16), needs.memory, &body, text, sizeof text);
    return body;
}

/* The cube falls on the base, beside a rigid tetrahedron on the ground. */
static void together(const char *cube, const char *base) {
    static const double nodes[12] = {0, 0, 0, 0.02, 0, 0, 0, 0.02, 0, 0, 0, 0.02};
    static const uint32_t triangles[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    char text[1024];
    struct VdmMember members[3];
    struct VdmTouching pairs[2];
    struct VdmJoint joint;
    struct VdmWorldOptions options;
    struct VdmWorldReport report;
    struct VdmWorld *world;
    struct VdmTouch touches[128];
    struct VdmMotion motion;
    struct VdmJointState state;
    double energy;
    size_t bytes = 0, found = 0, i;
    memset(members, 0, sizeof members);
    memset(pairs, 0, sizeof pairs);
    memset(&joint, 0, sizeof joint);
    members[0].body = member(cube);
    members[1].body = member(base);
    vdm_motion(members[0].body, &motion);
    motion.position[0] += 0.04;
    motion.position[1] += 0.04;
    motion.position[2] += 0.085;
    vdm_set_motion(members[0].body, &motion);
    members[2].nodes = nodes;
    members[2].triangles = triangles;
    members[2].n_nodes = 4;
    members[2].n_triangles = 4;
    members[2].mass.mass = 0.01;
    members[2].mass.centre[0] = members[2].mass.centre[1] = members[2].mass.centre[2] = 0.005;
    members[2].mass.moments[0] = members[2].mass.moments[1] = members[2].mass.moments[2] = 1e-6;
    for (i = 0; i < 3; i++) members[2].mass.axes[i][i] = 1.0;
    members[2].motion.position[0] = 0.08;
    members[2].motion.position[1] = 0.08;
    members[2].motion.position[2] = 0.3;
    members[2].motion.attitude[0] = 1.0;
    members[2].motion.momentum[2] = 0.01;
    pairs[0].second = 1;
    pairs[0].friction = 0.5;
    pairs[0].restitution = 0.5;
    pairs[0].nodes = VDM_NODES_FIRST;
    pairs[1].first = 2;
    pairs[1].friction = 0.25;
    vdm_default_world_options(&options);
    options.gravity[2] = -9.81;
    options.contacts = 128;
    joint.kind = VDM_CABLE;
    joint.first = 2;
    joint.second = 0;
    joint.anchors[0].kind = VDM_AT_POINT;
    joint.anchors[0].point[2] = 0.02;
    joint.anchors[1].kind = VDM_AT_PLACE;
    vdm_at_node(members[0].body, 3, &joint.anchors[1].place);
    joint.length = 0.24;
    printf("== world\n");
    if (vdm_world_measure(members, 3, pairs, 2, &joint, 1, &options, &bytes, text, sizeof text) < 0 ||
        vdm_world_bind(members, 3, pairs, 2, &joint, 1, &options, aligned_alloc(16, (bytes + 15) / 16 * 16), bytes, &world,
                       text, sizeof text) < 0) {
        printf("world refused: %s\n", text);
        return;
    }
    for (i = 0; i < 24; i++) {
        double saved[4096], at[7], speed[3];
        size_t k, most;
        if (vdm_world_step(world, 5, &report) < 0) printf("step refused: %s\n", vdm_world_message(world));
        printf("report %zu %zu %zu %zu %zu\n", report.contacts, report.pressed, report.left_out, report.sweeps, report.not_converged);
        bits("gap", &report.worst_gap, 2);
        vdm_world_energy(world, &energy);
        bits("energy", &energy, 1);
        vdm_world_pose(world, 2, at, at + 3);
        bits("pose", at, 7);
        vdm_world_motion(world, 2, &motion);
        bits("motion", motion.position, 13);
        vdm_world_in_space(world, 0, &joint.anchors[1].place, VDM_VELOCITY, speed);
        bits("speed", speed, 3);
        vdm_world_joint(world, 0, &state);
        bits("joint", state.force, 6);
        vdm_world_touches(world, touches, 128, &found);
        for (k = 0; k < found && k < 128; k++) {
            printf("touch %u %u\n", touches[k].first, touches[k].second);
            bits("touch", touches[k].position, 14);
        }
        most = vdm_world_saved_length(world);
        if (most <= 4096 && vdm_world_save(world, saved, most) >= 0) hashed("saved", (const uint8_t *)saved, 8 * most);
    }
}

#define SIZE(type) printf("size %zu\n", sizeof(struct type))

int main(int count, char **arguments) {
    int i;
    SIZE(VdmOptions), SIZE(VdmNeeds), SIZE(VdmPlace), SIZE(VdmParameter), SIZE(VdmRigidBody), SIZE(VdmMotion), SIZE(VdmCarried);
    SIZE(VdmWorldOptions), SIZE(VdmWorldReport), SIZE(VdmTouch), SIZE(VdmJointState), SIZE(VdmTouching), SIZE(VdmAnchor);
    SIZE(VdmJoint), SIZE(VdmMember), SIZE(VdmQuantity);
    for (i = 3; i < count; i++) {
        const char *name = strrchr(arguments[i], '/');
        march(arguments[i], name ? name + 1 : arguments[i], VDM_DOUBLE);
        march(arguments[i], name ? name + 1 : arguments[i], VDM_SINGLE);
    }
    together(arguments[1], arguments[2]);
    return 0;
}
