/*
 * A body in a microcontroller: the file lies in flash, SysTick calls 1000 times a second, and a host that listens
 * says where the body is touched and reads its probes.
 *
 * The host has a file `contacts.txt` with lines `TICK NODE FX FY FZ`, forces in mN: from that tick on the only contact
 * is this force at this node.
 */
#include "board.h"
#include "vademecum.h"

#define TICKS 1000u
#define EVERY 50u

/* The file, in flash beside the code. */
__asm__(".section .vademecum, \"a\" \n"
        ".balign 16 \n"
        "file: .incbin \"body.vdm\" \n"
        "file_end: \n"
        ".previous \n");
extern const uint8_t file[], file_end[];

static char contacts[1024];
static const char *at = contacts;

static void print_number(uint64_t number, unsigned base, unsigned digits) {
    char text[24];
    unsigned place = sizeof text - 1;
    text[place] = 0;
    do {
        text[--place] = "0123456789abcdef"[number % base];
        number /= base;
    } while (place > 0 && (number > 0 || place > sizeof text - 1 - digits));
    host_print(text + place);
}

static void print_named(const char *name, uint64_t number) {
    host_print(name);
    print_number(number, 10, 1);
    host_print("\n");
}

/* Prints a probe as its bits and in nm or nm/s. */
static void print_value(const char *name, double value) {
    union {
        double value;
        uint64_t bits;
    } as = {value};
    const double nano = value * 1e9;
    host_print(name);
    print_number(as.bits, 16, 16);
    host_print(nano < 0 ? " = -" : " = ");
    print_number((uint64_t)(nano < 0 ? -nano : nano), 10, 1);
    host_print(" e-9");
}

/* The next whole number of the host's file; 0 where there is none. */
static int next_number(int32_t *number) {
    int32_t sign = 1, found = 0;
    while (*at && *at != '-' && (*at < '0' || *at > '9')) at++;
    if (*at == '-') {
        sign = -1;
        at++;
    }
    if (*at < '0' || *at > '9') return 0;
    while (*at >= '0' && *at <= '9') found = 10 * found + (*at++ - '0');
    *number = sign * found;
    return 1;
}

/* The next line of the host's file. */
struct Touch {
    int32_t tick, node, force[3];
};

static int next_touch(struct Touch *touch) {
    return next_number(&touch->tick) && next_number(&touch->node) && next_number(&touch->force[0]) &&
           next_number(&touch->force[1]) && next_number(&touch->force[2]);
}

static int refused(const char *what) {
    host_print("refused: ");
    host_print(what);
    host_print("\n");
    return 1;
}

/* Takes the loads away and touches the body anew. */
static int touch(struct VdmBody *body, const struct Touch *asked) {
    struct VdmPlace place;
    const double force[3] = {asked->force[0] / 1000.0, asked->force[1] / 1000.0, asked->force[2] / 1000.0};
    vdm_clear(body);
    if (force[0] == 0 && force[1] == 0 && force[2] == 0) return 0;
    if (vdm_at_node(body, (uint32_t)asked->node, &place) < 0) return 1;
    return vdm_push(body, &place, force) < 0;
}

int main(void) {
    char text[120];
    struct VdmOptions options;
    struct VdmNeeds needs;
    struct VdmBody *body = NULL;
    struct Touch next;
    size_t bytes;
    const size_t length = (size_t)(file_end - file);
    uint8_t *memory = board_memory(&bytes);
    uint32_t sum = 0, worst = 0, late = 0;

    /* Ask, lend, bind. */
    vdm_default_options(&options);
    options.contacts = 1;
    options.places = 0;
    if (vdm_measure(file, length, &options, &needs, text, sizeof text) < 0) return refused(text);
    if (needs.memory > bytes) return refused("the body does not fit into RAM");
    if (vdm_bind(file, length, &options, memory, needs.memory, &body, text, sizeof text) < 0) return refused(text);

    const int32_t host = host_open("contacts.txt");
    if (host < 0) return refused("the host has no file contacts.txt");
    contacts[host_read(host, contacts, sizeof contacts - 1)] = 0;
    int more = next_touch(&next);

    board_start_clock();
    for (uint32_t tick = 0; tick < TICKS; tick++) {
        if (board_wait_for_tick() != tick + 1) late++;
        const uint32_t began = board_count();
        while (more && (uint32_t)next.tick <= tick) {
            if (touch(body, &next)) return refused(vdm_message(body));
            more = next_touch(&next);
        }
        const uint32_t before = board_count();
        if (vdm_step(body, 1) < 0) return refused(vdm_message(body));
        const uint32_t after = board_count();
        sum += board_between(before, after);
        if (board_between(began, after) > worst) worst = board_between(began, after);
        if ((tick + 1) % EVERY == 0) {
            for (uint32_t probe = 0; probe < needs.probes; probe++) {
                double moved = 0, speed = 0;
                vdm_probe(body, probe, VDM_DISPLACEMENT, &moved);
                vdm_probe(body, probe, VDM_VELOCITY, &speed);
                host_print("step ");
                print_number(tick + 1, 10, 1);
                host_print(" probe ");
                print_number(probe, 10, 1);
                print_value(" moved ", moved);
                print_value(" speed ", speed);
                host_print("\n");
            }
        }
    }
    print_named("modes ", needs.modes);
    print_named("lent ", needs.memory);
    print_named("stack ", board_stack());
    print_named("counts ", sum);
    print_named("worst ", worst);
    print_named("late ", late);
    return 0;
}
