/* Steps in single precision on a Cortex-M4F without an operating system: prints the bits of the
 * last torques, the stack and the instructions of a step, of the paper's arm and of a Panda. */
#include "board.h"
#include "single.h"

static float q[MOST_JOINTS], dq[MOST_JOINTS], tau[MOST_JOINTS];
static int failed;

static void start(void) { failed |= steadyarm_single_start(); }
static void two_link(void) { failed |= steadyarm_single_two_link(q, dq, tau); }
static void panda(void) { failed |= steadyarm_single_panda(q, dq, tau); }

static void run(const char *const names[3], void (*step)(void), int joints) {
    uint64_t total = 0;
    uint32_t most = 0, stack = 0;
    for (int k = 0; k < SAMPLES; k++) {
        sample(k, joints, q, dq);
        uint32_t taken;
        if (k == 0) {
            stack = stack_of(step);
        } else {
            taken = instructions_of(step);
            most = taken > most ? taken : most;
            total += taken;
        }
    }
    print_number(names[0], total / (SAMPLES - 1), 10, 1);
    print_number(names[1], most, 10, 1);
    print_number(names[2], stack, 10, 1);
    for (int n = 0; n < joints; n++) {
        print_number("bits", bits_of(&tau[n]), 16, 8);
    }
}

static void measure(void) {
    static const char *const of_two[3] = {
        "two-link-instructions", "two-link-instructions-at-most", "two-link-stack"};
    static const char *const of_panda[3] = {
        "panda-instructions", "panda-instructions-at-most", "panda-stack"};
    start_counting();
    start();
    run(of_two, two_link, 2);
    run(of_panda, panda, 7);
    leave(failed != 0);
}
