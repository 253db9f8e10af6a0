/* Start of a Cortex-M4F or M33, its SysTick timer, and semihosting: what a debugger or QEMU offers a program. */
#include "board.h"

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define SYSTICK_CONTROL REGISTER(0xE000E010)
#define SYSTICK_RELOAD REGISTER(0xE000E014)
#define SYSTICK_VALUE REGISTER(0xE000E018)
#define COPROCESSORS REGISTER(0xE000ED88)

#define PAINT 0xC5C5C5C5u

extern uint32_t data_start[], data_end[], data_in_flash[], bss_start[], bss_end[], pool_start[];
extern uint32_t stack_bottom[], stack_top[];

int main(void);
void reset(void);
static volatile uint32_t ticks;

static void fault(void) {
    host_print("fault\n");
    host_exit(1);
}

static void systick(void) {
    ticks = ticks + 1;
}

/* The stack, the start, and the handlers of faults and of SysTick; nothing else interrupts. */
struct Vectors {
    uint32_t *stack;
    void (*handlers[15])(void);
};
extern const struct Vectors vectors;
__attribute__((section(".vectors"), used)) const struct Vectors vectors = {
    stack_top,
    {reset, fault, fault, fault, fault, fault, fault, 0, 0, 0, fault, fault, 0, fault, systick},
};

/* In assembly, because a compiler may use floating-point registers or the stack before C may. */
__attribute__((naked, used)) void reset(void) {
    __asm__ volatile(
        "ldr r0, =0xE000ED88 \n" /* the floating-point unit */
        "ldr r1, [r0] \n"
        "orr r1, r1, #0x00F00000 \n"
        "str r1, [r0] \n"
        "dsb \n"
        "isb \n"
        "bl start \n");
}

__attribute__((used)) void start(void) {
    const uint32_t *from = data_in_flash;
    for (uint32_t *to = data_start; to < data_end; to++) *to = *from++;
    for (uint32_t *to = bss_start; to < bss_end; to++) *to = 0;
    /* A little below where the stack is now. */
    uint32_t *here = (uint32_t *)__builtin_frame_address(0) - 32;
    for (uint32_t *to = stack_bottom; to < here; to++) *(volatile uint32_t *)to = PAINT;
    host_exit((uint32_t)main());
}

void board_start_clock(void) {
    SYSTICK_RELOAD = CLOCK_HZ / 1000u - 1u;
    SYSTICK_VALUE = 0;
    SYSTICK_CONTROL = 7; /* on, with an interrupt, from the clock of the core */
}

uint32_t board_wait_for_tick(void) {
    static uint32_t seen;
    while (ticks == seen) __asm__ volatile("wfi" ::: "memory");
    seen = ticks;
    return seen;
}

uint32_t board_count(void) {
    return CLOCK_HZ / 1000u - 1u - SYSTICK_VALUE;
}

uint32_t board_between(uint32_t earlier, uint32_t later) {
    return later >= earlier ? later - earlier : later + CLOCK_HZ / 1000u - earlier;
}

uint8_t *board_memory(size_t *bytes) {
    *bytes = (size_t)((uint8_t *)stack_bottom - (uint8_t *)pool_start);
    return (uint8_t *)pool_start;
}

size_t board_stack(void) {
    const uint32_t *at = stack_bottom;
    while (at < stack_top && *at == PAINT) at++;
    return (size_t)((const uint8_t *)stack_top - (const uint8_t *)at);
}

static int32_t semihosting(uint32_t operation, const void *argument) {
    register uint32_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return (int32_t)r0;
}

void host_print(const char *text) {
    semihosting(0x04, text);
}

int32_t host_open(const char *path) {
    uint32_t length = 0;
    while (path[length]) length++;
    const uint32_t arguments[3] = {(uint32_t)path, 0, length};
    return semihosting(0x01, arguments);
}

size_t host_read(int32_t file, char *out, size_t capacity) {
    const uint32_t arguments[3] = {(uint32_t)file, (uint32_t)out, capacity};
    /* The answer is how many bytes are missing. */
    const uint32_t missing = (uint32_t)semihosting(0x06, arguments);
    return missing > capacity ? 0 : capacity - missing;
}

void host_exit(uint32_t code) {
    const uint32_t arguments[2] = {0x20026, code};
    semihosting(0x20, arguments);
    for (;;) {
    }
}
