/*
 * A finger that presses on a body at 1 kHz and feels it: one step of a millisecond in each tick.
 *
 *   cc -std=c99 -O2 haptic_loop.c -I ../include ../../../target/release/libvademecum.a -lm -lpthread -ldl -o haptic_loop
 *   ./haptic_loop beam.vdm
 */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "vademecum.h"

/* All bytes of a file; the caller frees them. */
static uint8_t *read_file(const char *path, size_t *length) {
    FILE *file = fopen(path, "rb");
    uint8_t *bytes = NULL;
    long size;
    if (!file) return NULL;
    if (fseek(file, 0, SEEK_END) == 0 && (size = ftell(file)) > 0) {
        rewind(file);
        bytes = malloc((size_t)size);
        *length = (size_t)size;
        if (bytes && fread(bytes, 1, *length, file) != *length) {
            free(bytes);
            bytes = NULL;
        }
    }
    fclose(file);
    return bytes;
}

int main(int count, char **arguments) {
    char text[240];
    size_t length = 0;
    struct VdmNeeds needs;
    struct VdmBody *body = NULL;
    struct VdmPlace place;
    const double finger[3] = {0.9, 0.05, 0.1};
    double under[3] = {0, 0, 0}, tip = 0;
    int tick;

    if (count != 2) {
        fprintf(stderr, "usage: %s FILE.vdm\n", arguments[0]);
        return 2;
    }
    if (vdm_abi() != VDM_ABI) return 3;
    uint8_t *file = read_file(arguments[1], &length);
    if (!file) {
        perror(arguments[1]);
        return 1;
    }

    /* Ask, lend, bind. Nothing is allocated from here on. */
    if (vdm_measure(file, length, NULL, &needs, text, sizeof text) < 0) {
        fprintf(stderr, "%s: %s\n", arguments[1], text);
        return 1;
    }
    void *memory = malloc(needs.memory);
    if (!memory || vdm_bind(file, length, NULL, memory, needs.memory, &body, text, sizeof text) < 0) {
        fprintf(stderr, "%s: %s\n", arguments[1], text);
        return 1;
    }
    if (vdm_locate(body, finger, &place) < 0) return 1;

    for (tick = 0; tick < 1000; tick++) {
        /* The finger sinks by 2 mm in a second and pushes with 2 N for each millimetre that the body does not
           give way. */
        const double depth = 2e-3 * tick / 1000.0;
        double force[3] = {0, 0, 0};
        vdm_point(body, &place, VDM_DISPLACEMENT, under);
        force[2] = -2e3 * (depth + under[2]);
        vdm_clear(body);
        vdm_push(body, &place, force);
        if (vdm_step(body, 1) < 0) {
            fprintf(stderr, "step %d: %s\n", tick, vdm_message(body));
            return 1;
        }
    }
    vdm_point(body, &place, VDM_DISPLACEMENT, under);
    vdm_probe(body, 0, VDM_VELOCITY, &tip);
    printf("%.17e %.17e\n", under[2], tip);
    free(memory);
    free(file);
    return 0;
}
