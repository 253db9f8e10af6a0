/* Every call of a world, what is refused, and that nothing is touched by it. Takes a free cube, a block that is held, and a link
 * with two ports; compiled as C99 and as C++17. */
#include <math.h>
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
            exit(1);                                                 \
        }                                                            \
    } while (0)

static char text[240];
static void *kept[64];
static int n_kept;

static void *lent(size_t bytes) {
    void *memory = malloc(bytes);
    CHECK(memory && n_kept < 64);
    kept[n_kept++] = memory;
    return memory;
}

static struct VdmBody *body_of(const char *path, int precision) {
    struct VdmNeeds needs;
    struct VdmOptions options;
    struct VdmBody *body = NULL;
    FILE *source = fopen(path, "rb");
    uint8_t *file = (uint8_t *)lent(4000000);
    size_t length;
    CHECK(source);
    length = fread(file, 1, 4000000, source);
    fclose(source);
    vdm_default_options(&options);
    options.precision = precision;
    options.contacts = 128;
    options.time_step = 1e-3;
    CHECK(vdm_measure(file, length, &options, &needs, text, sizeof text) == VDM_OK);
    CHECK(vdm_bind(file, length, &options, (uint8_t *)lent(needs.memory), needs.memory, &body, text, sizeof text) ==
          VDM_OK);
    return body;
}

static struct VdmWorldOptions falling(void) {
    struct VdmWorldOptions options;
    vdm_default_world_options(&options);
    CHECK(options.gravity[2] == 0 && options.contacts == 256 && options.sweeps > 0);
    options.gravity[2] = -9.81;
    options.contacts = 128;
    return options;
}

static struct VdmWorld *world_of(const struct VdmMember *members, size_t n, const struct VdmTouching *pairs, size_t n_pairs,
                                 const struct VdmJoint *joints, size_t n_joints, size_t *most) {
    const struct VdmWorldOptions options = falling();
    struct VdmWorld *world = NULL;
    size_t bytes = 0;
    uint8_t *memory;
    CHECK(vdm_world_measure(members, n, pairs, n_pairs, joints, n_joints, &options, &bytes, text, sizeof text) == VDM_OK);
    memory = (uint8_t *)lent(bytes);
    CHECK(vdm_world_bind(members, n, pairs, n_pairs, joints, n_joints, &options, memory, bytes - 16, &world, text,
                         sizeof text) == VDM_MEMORY && !world && strstr(text, "are needed"));
    CHECK(vdm_world_bind(members, n, pairs, n_pairs, joints, n_joints, &options, memory + 8, bytes, &world, text,
                         sizeof text) == VDM_MEMORY && !world);
    CHECK(vdm_world_bind(members, n, pairs, n_pairs, joints, n_joints, &options, memory, bytes, &world, text,
                         sizeof text) == VDM_OK && world);
    if (most) *most = bytes;
    return world;
}

/* A closed cube of 20 mm. */
static const double corners[24] = {0,    0,    0, 0.02, 0,    0, 0,    0.02, 0, 0.02, 0.02, 0,
                                   0, 0, 0.02, 0.02, 0, 0.02, 0, 0.02, 0.02, 0.02, 0.02, 0.02};
static const uint32_t faces[36] = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                   2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};

static struct VdmMember die(void) {
    struct VdmMember member;
    int k;
    memset(&member, 0, sizeof member);
    member.nodes = corners;
    member.n_nodes = 8;
    member.triangles = faces;
    member.n_triangles = 12;
    member.mass.mass = 0.004;
    for (k = 0; k < 3; k++) {
        member.mass.centre[k] = 0.01;
        member.mass.moments[k] = 0.004 * 0.02 * 0.02 / 6;
        member.mass.axes[k][k] = 1;
    }
    return member;
}

static void touching(const char *cube, const char *base, int precision) {
    struct VdmMember members[4];
    struct VdmTouching pairs[3];
    struct VdmWorldReport report;
    struct VdmTouch touches[128];
    struct VdmMotion motion, back, thrown;
    struct VdmPlace place;
    struct VdmWorld *world;
    double energy, one, carried = 0, moved[3], rest[3], position[3], attitude[4], *saved;
    const double corner[3] = {0.08, 0.08, 0.08}, none[3] = {0, 0, 0}, far_down[3] = {0, 0, -0.5};
    const double stand[4] = {1, 0, 0, 0}, no_attitude[4] = {1, 1, 0, 0}, push[3] = {0, 0.5, 0};
    size_t found, k, numbers, most[2];
    uint8_t *states[2];
    int twice;
    memset(members, 0, sizeof members);
    memset(pairs, 0, sizeof pairs);
    members[0].body = body_of(cube, precision);
    members[1].body = body_of(base, precision);
    members[2] = die();
    members[2].motion.position[0] = 5; /* falls beside the base */
    members[3] = die();
    members[3].mass.mass = 0;
    members[3].motion.position[2] = -0.5;
    CHECK(vdm_motion(members[0].body, &motion) == VDM_OK);
    motion.position[0] += 0.04;
    motion.position[1] += 0.04;
    motion.position[2] += 0.085;
    CHECK(vdm_set_motion(members[0].body, &motion) == VDM_OK);
    pairs[0].second = 1;
    pairs[0].friction = 0.5;
    pairs[0].restitution = 0.5;
    pairs[0].nodes = VDM_NODES_FIRST;
    pairs[1].first = 2;
    pairs[1].second = 1;
    pairs[2].first = 3;
    pairs[2].second = 1;
    world = world_of(members, 4, pairs, 3, NULL, 0, NULL);
    CHECK(*vdm_world_message(world) == 0 && *vdm_world_message(NULL));

    CHECK(vdm_world_step(world, 600, &report) == VDM_OK && report.not_converged == 0 && report.left_out == 0);
    CHECK(report.pressed > 0 && report.pressed <= report.contacts && report.sweeps > 0 && report.energy_given_away > 0);
    CHECK(vdm_world_touches(world, touches, 128, &found) == VDM_OK && found == report.contacts);
    for (k = 0; k < found; k++) {
        carried += touches[k].force[2];
        CHECK(touches[k].first == 0 && touches[k].second == 1 && touches[k].normal[2] > 0.9 && touches[k].gap < 1e-3);
        CHECK(fabs(touches[k].position[2] - 0.08) < 2e-3 && fabs(touches[k].slip[0]) < 1e-3 && touches[k].pressure >= 0);
    }
    CHECK(fabs(carried / (0.08 * 0.08 * 0.08 * 1000 * 9.81) - 1) < 0.05);
    CHECK(vdm_world_touches(world, NULL, 0, &k) == VDM_OK && k == found);
    CHECK(vdm_world_energy(world, &energy) == VDM_OK && energy > 0);

    /* Places in space. */
    CHECK(vdm_locate(members[0].body, corner, &place) == VDM_OK);
    CHECK(vdm_world_in_space(world, 0, &place, VDM_DISPLACEMENT, moved) == VDM_OK);
    CHECK(vdm_in_space(members[0].body, &place, VDM_DISPLACEMENT, rest) == VDM_OK && moved[2] == rest[2]);
    CHECK(vdm_world_pose(world, 0, position, attitude) == VDM_OK && fabs(position[2] - 0.08) < 2e-3);
    CHECK(vdm_world_in_space(world, 2, &place, VDM_DISPLACEMENT, moved) == VDM_ARGUMENT);
    CHECK(vdm_world_in_space(world, 0, &place, 7, moved) == VDM_ARGUMENT);
    CHECK(vdm_locate(members[1].body, corner, &place) == VDM_OK);
    CHECK(vdm_world_in_space(world, 1, &place, VDM_DISPLACEMENT, moved) == VDM_OK && fabs(moved[2] - 0.08) < 1e-3);
    CHECK(vdm_world_in_space(world, 1, &place, VDM_VELOCITY, moved) == VDM_OK && fabs(moved[2]) < 1);

    /* Rigid members, and the base, which the host moves. */
    CHECK(vdm_world_motion(world, 2, &motion) == VDM_OK && motion.momentum[2] < -0.004 * 9.81 * 0.59);
    CHECK(vdm_world_push(world, 2, motion.position, push) == VDM_OK && vdm_world_step(world, 1, &report) == VDM_OK);
    CHECK(vdm_world_motion(world, 2, &back) == VDM_OK && fabs(back.momentum[1] - 0.5e-3) < 1e-12);
    CHECK(vdm_world_set_motion(world, 2, &motion) == VDM_OK && vdm_world_forget(world) == VDM_OK);
    CHECK(vdm_world_motion(world, 0, &back) == VDM_ARGUMENT && strstr(vdm_world_message(world), "vdm_motion"));
    CHECK(vdm_world_lead(world, 1, none, no_attitude) == VDM_ARGUMENT && vdm_world_lead(world, 0, none, stand) == VDM_ARGUMENT);
    CHECK(vdm_world_lead(world, 3, far_down, stand) == VDM_OK && vdm_world_lead(world, 1, none, stand) == VDM_OK);
    CHECK(vdm_world_pose(world, 4, position, attitude) == VDM_ARGUMENT && vdm_world_joint(world, 0, NULL) == VDM_ARGUMENT);
    CHECK(vdm_world_break(world, 0) == VDM_ARGUMENT);
    thrown = motion;
    thrown.momentum[0] = (double)1e308 * 10;
    CHECK(vdm_world_set_motion(world, 2, &thrown) == VDM_ARGUMENT);
    CHECK(vdm_world_push(world, 2, motion.position, thrown.momentum) == VDM_LOAD);
    CHECK(vdm_world_step(NULL, 1, &report) == VDM_ARGUMENT && vdm_world_step(world, 1, NULL) == VDM_ARGUMENT);

    /* State: bit by bit. */
    CHECK(vdm_world_step(world, 20, &report) == VDM_OK);
    numbers = vdm_world_saved_length(world);
    CHECK(numbers > 0 && vdm_world_saved_length(NULL) == 0);
    saved = (double *)lent(numbers * sizeof(double));
    CHECK(vdm_world_save(world, saved, numbers - 1) == VDM_MEMORY && vdm_world_save(world, saved, numbers) == VDM_OK);
    for (k = 0; k < 2; k++) {
        most[k] = vdm_saved_length(members[k].body);
        states[k] = (uint8_t *)lent(most[k]);
        CHECK(vdm_save(members[k].body, states[k], most[k], &most[k]) == VDM_OK);
    }
    one = 0;
    for (twice = 0; twice < 2; twice++) {
        CHECK(vdm_world_step(world, 30, &report) == VDM_OK && vdm_world_energy(world, &energy) == VDM_OK);
        CHECK(twice == 0 || energy == one);
        one = energy;
        CHECK(vdm_world_restore(world, saved, numbers) == VDM_OK);
        for (k = 0; k < 2; k++) CHECK(vdm_restore(members[k].body, states[k], most[k]) == VDM_OK);
    }
    CHECK(vdm_world_energy(world, &one) == VDM_OK);
    saved[0] = 1e9;
    CHECK(vdm_world_restore(world, saved, numbers) == VDM_WORLD && vdm_world_restore(world, saved, 1) == VDM_MEMORY);
    CHECK(vdm_world_energy(world, &energy) == VDM_OK && energy == one);

    /* A push on a body acts in the world, too. */
    CHECK(vdm_locate(members[0].body, corner, &place) == VDM_OK && vdm_push(members[0].body, &place, push) == VDM_OK);
    CHECK(vdm_motion(members[0].body, &back) == VDM_OK && vdm_world_step(world, 1, &report) == VDM_OK);
    CHECK(vdm_motion(members[0].body, &motion) == VDM_OK && motion.momentum[1] > back.momentum[1]);
}

static void joined(const char *link, int precision) {
    struct VdmMember members[3];
    struct VdmJoint joints[2];
    struct VdmJointState state;
    struct VdmWorldReport report;
    struct VdmMotion motion, before;
    struct VdmWorld *world;
    double weight, energy;
    int start, end;
    memset(members, 0, sizeof members);
    memset(joints, 0, sizeof joints);
    members[0].body = body_of(link, precision);
    members[1] = die();
    members[1].motion.position[0] = 0.21;
    members[1].motion.position[1] = 0.01;
    members[1].motion.position[2] = 0.01;
    start = vdm_find(members[0].body, VDM_PORTS, "start");
    end = vdm_find(members[0].body, VDM_PORTS, "end");
    CHECK(start == 0 && end == 1 && vdm_find(members[0].body, VDM_PORTS, "middle") == -1);
    CHECK(vdm_name(members[0].body, VDM_PORTS, 1, text, sizeof text) == VDM_OK && strcmp(text, "end") == 0);

    /* A hinge on the ground, which is a rigid member without nodes, and a ball at the other end. */
    joints[0].kind = VDM_HINGE;
    joints[0].second = 2;
    joints[0].anchors[0].kind = VDM_AT_PORT;
    joints[0].anchors[0].port = (uint32_t)start;
    joints[0].anchors[1].kind = VDM_AT_POINT;
    joints[0].anchors[1].point[1] = 0.01;
    joints[0].anchors[1].point[2] = 0.01;
    joints[1].kind = VDM_BALL;
    joints[1].second = 1;
    joints[1].anchors[0].kind = VDM_AT_PORT;
    joints[1].anchors[0].port = (uint32_t)end;
    joints[1].anchors[1].kind = VDM_AT_POINT;
    world = world_of(members, 3, NULL, 0, joints, 2, NULL);
    CHECK(vdm_world_step(world, 200, &report) == VDM_OK && vdm_world_energy(world, &energy) == VDM_OK && energy > 0);
    CHECK(vdm_world_joint(world, 0, &state) == VDM_OK && !state.broken);
    weight = sqrt(state.force[0] * state.force[0] + state.force[2] * state.force[2]);
    CHECK(weight > 0.05 && weight < 20);
    CHECK(vdm_world_break(world, 1) == VDM_OK && vdm_world_motion(world, 1, &before) == VDM_OK);
    CHECK(vdm_world_step(world, 10, &report) == VDM_OK && vdm_world_joint(world, 1, &state) == VDM_OK && state.broken);
    CHECK(state.force[2] == 0 && vdm_world_motion(world, 1, &motion) == VDM_OK);
    CHECK(fabs(motion.momentum[2] - before.momentum[2] + 0.004 * 9.81 * 0.01) < 1e-9);
}

static void refused(const char *cube, const char *base) {
    struct VdmMember members[2];
    struct VdmTouching pair;
    struct VdmJoint joint;
    struct VdmWorldOptions options = falling();
    size_t bytes = 0;
    memset(members, 0, sizeof members);
    memset(&pair, 0, sizeof pair);
    memset(&joint, 0, sizeof joint);
    members[0].body = body_of(cube, VDM_SINGLE);
    members[1].body = body_of(base, VDM_DOUBLE);
#define MEASURED(n) vdm_world_measure(members, n, NULL, 0, NULL, 0, &options, &bytes, text, sizeof text)
    CHECK(MEASURED(2) == VDM_WORLD && strstr(text, "one precision"));
    members[1].body = members[0].body;
    CHECK(MEASURED(2) == VDM_WORLD && strstr(text, "once"));
    members[1] = die();
    members[1].n_nodes = 7;
    CHECK(MEASURED(2) == VDM_WORLD && strstr(text, "rigid member"));
    members[1] = die();
    members[1].nodes = NULL;
    CHECK(MEASURED(2) == VDM_ARGUMENT && strstr(text, "`nodes`"));
    members[1] = die();
    CHECK(MEASURED(2) == VDM_OK && bytes > 0);
    CHECK(vdm_world_measure(NULL, 2, NULL, 0, NULL, 0, &options, &bytes, text, sizeof text) == VDM_ARGUMENT);
    CHECK(vdm_world_measure(members, 2, NULL, 0, NULL, 0, NULL, NULL, NULL, 0) == VDM_ARGUMENT);
    joint.kind = 9;
    CHECK(vdm_world_measure(members, 2, NULL, 0, &joint, 1, NULL, &bytes, text, sizeof text) == VDM_ARGUMENT);
    {
        uint8_t *memory = (uint8_t *)lent(2 * bytes);
        struct VdmWorld *world = NULL;
#define BOUND(pairs, n_pairs, joints, n_joints)                                                                   \
    vdm_world_bind(members, 2, pairs, n_pairs, joints, n_joints, &options, memory, 2 * bytes, &world, text, sizeof text)
        CHECK(BOUND(&pair, 1, NULL, 0) == VDM_WORLD && !world && strstr(text, "pair 0"));
        pair.second = 1;
        pair.friction = -1;
        CHECK(BOUND(&pair, 1, NULL, 0) == VDM_WORLD && !world);
        pair.friction = 0;
        pair.nodes = 9;
        CHECK(BOUND(&pair, 1, NULL, 0) == VDM_ARGUMENT && strstr(text, "VdmNodes"));
        joint.kind = VDM_BALL;
        joint.second = 1;
        joint.anchors[0].kind = 9;
        CHECK(BOUND(NULL, 0, &joint, 1) == VDM_ARGUMENT && strstr(text, "VdmAnchorKind"));
        joint.anchors[0].kind = VDM_AT_PORT;
        joint.anchors[1].kind = VDM_AT_POINT;
        CHECK(BOUND(NULL, 0, &joint, 1) == VDM_WORLD && strstr(text, "joint 0"));
        options.recover = -1;
        CHECK(BOUND(NULL, 0, NULL, 0) == VDM_WORLD && strstr(text, "option"));
        CHECK(strstr(vdm_status_text(VDM_WORLD), "world"));
    }
}

int main(int count, char **arguments) {
    int precision;
    CHECK(count == 4);
    for (precision = VDM_SINGLE; precision <= VDM_DOUBLE; precision++) {
        touching(arguments[1], arguments[2], precision);
        joined(arguments[3], precision);
        while (n_kept > 0) free(kept[--n_kept]);
    }
    refused(arguments[1], arguments[2]);
    while (n_kept > 0) free(kept[--n_kept]);
    return 0;
}
