/* The same steps on a Cortex-M7 without an operating system: prints the hash, the stack that
 * building and a step take, the sizes of the parts, and the instructions of a step. */
#include "board.h"
#include "samples.h"

static double q[2], dq[2], tau[2];
static int failed;

static void start(void) { failed |= steadyarm_start(); }
static void step(void) { failed |= steadyarm_step(q, dq, tau); }

static __attribute__((noinline)) void measure(void) {
    uint64_t hash = HASH_START, total = 0;
    uint32_t deepest = 0, most = 0;
    size_t sizes[4];
    start_counting();
    print_number("build-stack", stack_of(start), 10, 1);
    for (int k = 0; k < SAMPLES; k++) {
        sample(k, q, dq);
        uint32_t taken;
        if (k % 10 == 0) {
            taken = stack_of(step);
            deepest = taken > deepest ? taken : deepest;
        } else {
            taken = instructions_of(step);
            most = taken > most ? taken : most;
            total += taken;
        }
        hash = hashed(hash, tau);
    }
    q[0] = __builtin_nan("");
    if (steadyarm_step(q, dq, tau) == 0) {
        leave(2);
    }
    steadyarm_sizes(sizes);
    print_number("step-stack", deepest, 10, 1);
    print_number("controller", sizes[0], 10, 1);
    print_number("basis", sizes[1], 10, 1);
    print_number("state", sizes[2], 10, 1);
    print_number("memory", sizes[3], 10, 1);
    print_number("step-instructions", total / (SAMPLES - SAMPLES / 10), 10, 1);
    print_number("step-instructions-at-most", most, 10, 1);
    print_number("hash", hash, 16, 16);
    leave(failed != 0);
}
