/* The same steps on this machine: prints the bits of the last torques. */
#include <stdio.h>

#include "single.h"

static int run(int (*step)(const float *, const float *, float *), int joints) {
    float q[MOST_JOINTS], dq[MOST_JOINTS], tau[MOST_JOINTS];
    for (int k = 0; k < SAMPLES; k++) {
        sample(k, joints, q, dq);
        if (step(q, dq, tau) != 0) {
            return 1;
        }
    }
    for (int n = 0; n < joints; n++) {
        printf("bits %08lx\n", (unsigned long)bits_of(&tau[n]));
    }
    return 0;
}

int main(void) {
    return steadyarm_single_start() != 0 || run(steadyarm_single_two_link, 2) != 0 ||
           run(steadyarm_single_panda, 7) != 0;
}
