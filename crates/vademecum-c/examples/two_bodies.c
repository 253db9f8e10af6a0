/*
 * Two bodies that touch: a soft cube falls on a soft block that is held below, at 1 kHz.
 *
 *   cc -std=c99 -O2 two_bodies.c -I ../include ../../../target/release/libvademecum.a -lm -lpthread -ldl -o two_bodies
 *   ./two_bodies cube.vdm base.vdm
 *
 * docs/how-to/join-bodies.md has the problem files of the two.
 */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "vademecum.h"

/* A file and its body; their memory stays for as long as the program runs. */
static struct VdmBody *body_of(const char *path) {
    char text[240] = "it cannot be read";
    struct VdmNeeds needs;
    struct VdmOptions options;
    struct VdmBody *body = NULL;
    FILE *source = fopen(path, "rb");
    uint8_t *file = malloc(8000000);
    size_t length = source && file ? fread(file, 1, 8000000, source) : 0;
    if (source) fclose(source);
    vdm_default_options(&options);
    /* Those of the world that it will be in. */
    options.contacts = 128;
    options.time_step = 1e-3;
    if (length > 0 && vdm_measure(file, length, &options, &needs, text, sizeof text) >= 0) {
        void *memory = malloc(needs.memory);
        if (memory) vdm_bind(file, length, &options, memory, needs.memory, &body, text, sizeof text);
    }
    if (!body) {
        fprintf(stderr, "%s: %s\n", path, text);
        exit(1);
    }
    return body;
}

int main(int count, char **arguments) {
    char text[240];
    struct VdmMember members[2];
    struct VdmTouching pair;
    struct VdmWorldOptions options;
    struct VdmWorldReport report;
    struct VdmWorld *world = NULL;
    struct VdmTouch touches[128];
    struct VdmMotion motion;
    double energy = 0;
    size_t bytes = 0, found = 0, k;
    int step;

    if (count != 3) {
        fprintf(stderr, "usage: %s CUBE.vdm BASE.vdm\n", arguments[0]);
        return 2;
    }
    if (vdm_abi() != VDM_ABI) return 3;

    /* The cube flies: its motion is its own. The base stands where its file has it. */
    memset(members, 0, sizeof members);
    members[0].body = body_of(arguments[1]);
    members[1].body = body_of(arguments[2]);
    if (vdm_motion(members[0].body, &motion) < 0) {
        fprintf(stderr, "%s: %s\n", arguments[1], vdm_message(members[0].body));
        return 1;
    }
    motion.position[0] += 0.04;
    motion.position[1] += 0.04;
    motion.position[2] += 0.085; /* 5 mm above the base */
    vdm_set_motion(members[0].body, &motion);

    memset(&pair, 0, sizeof pair);
    pair.second = 1;
    pair.friction = 0.5;
    pair.restitution = 0.5;
    pair.nodes = VDM_NODES_FIRST;
    vdm_default_world_options(&options);
    options.gravity[2] = -9.81;
    options.contacts = 128;

    /* Ask, lend, bind. Nothing is allocated from here on. */
    if (vdm_world_measure(members, 2, &pair, 1, NULL, 0, &options, &bytes, text, sizeof text) < 0) {
        fprintf(stderr, "%s\n", text);
        return 1;
    }
    void *memory = malloc(bytes);
    if (!memory || vdm_world_bind(members, 2, &pair, 1, NULL, 0, &options, memory, bytes, &world, text,
                                  sizeof text) < 0) {
        fprintf(stderr, "%s\n", text);
        return 1;
    }

    for (step = 50; step <= 500; step += 50) {
        double carried = 0;
        if (vdm_world_step(world, 50, &report) < 0) {
            fprintf(stderr, "%s\n", vdm_world_message(world));
            return 1;
        }
        vdm_world_touches(world, touches, 128, &found);
        for (k = 0; k < found; k++) carried += touches[k].force[2];
        vdm_motion(members[0].body, &motion);
        printf("%.3f s: height %.3f mm, %d contacts carry %.2f N\n", 1e-3 * step, 1e3 * (motion.position[2] - 0.12),
               (int)report.pressed, carried);
    }
    vdm_world_energy(world, &energy);
    printf("%.17e %.17e\n", motion.position[2], energy);
    return 0;
}
