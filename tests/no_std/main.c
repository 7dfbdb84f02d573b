/* Steps the controller without std a thousand times; prints the last torque and a hash of all. */
#include <math.h>
#include <stdio.h>

#include "samples.h"

int main(void) {
    uint64_t hash = HASH_START;
    double tau[2] = {0.0, 0.0};
    if (steadyarm_start() != 0) {
        return 1;
    }
    for (int k = 0; k < SAMPLES; k++) {
        double q[2], dq[2];
        sample(k, q, dq);
        if (steadyarm_step(q, dq, tau) != 0) {
            return 2;
        }
        hash = hashed(hash, tau);
    }
    double wrong[2] = {NAN, 0.0};
    if (steadyarm_step(wrong, wrong, tau) == 0) {
        return 3;
    }
    printf("torque %.17g %.17g hash %016llx\n", tau[0], tau[1], (unsigned long long)hash);
    return 0;
}
