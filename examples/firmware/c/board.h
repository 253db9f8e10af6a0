/* The little that this firmware wants of a board: a clock of 1 kHz, memory, and a host that listens. */
#ifndef BOARD_H
#define BOARD_H

#include <stddef.h>
#include <stdint.h>

/* Counts of the clock in a second; the check gives it for each board. */
#ifndef CLOCK_HZ
#define CLOCK_HZ 25000000u
#endif

/* Starts the clock; one tick is a millisecond. */
void board_start_clock(void);
/* Sleeps until the next tick; how many ticks there have been, 1 for the first. */
uint32_t board_wait_for_tick(void);
/* The clock, in counts below those of a millisecond. */
uint32_t board_count(void);
/* Counts between two times that are less than a millisecond apart. */
uint32_t board_between(uint32_t earlier, uint32_t later);
/* All RAM that nothing else uses, aligned to 16, and its length. */
uint8_t *board_memory(size_t *bytes);
/* The largest depth of the stack so far, in bytes. */
size_t board_stack(void);

/* Prints a text on the host. */
void host_print(const char *text);
/* Opens a file of the host for reading; negative if there is none. */
int32_t host_open(const char *path);
/* Reads up to `capacity` bytes; how many there were. */
size_t host_read(int32_t file, char *out, size_t capacity);
/* Ends the program on the host: 0 is success. */
void host_exit(uint32_t code);

#endif
