/* The samples that the controllers in single precision are stepped with. */
#ifndef SINGLE_H
#define SINGLE_H

#include <stdint.h>
#include <string.h>

#define SAMPLES 500
#define MOST_JOINTS 7

/* In the crate, see src/single.rs. 0 if all went well. */
int steadyarm_single_start(void);
int steadyarm_single_two_link(const float *q, const float *dq, float *tau);
int steadyarm_single_panda(const float *q, const float *dq, float *tau);

/* Sums and products only: the same numbers everywhere. */
static inline void sample(int k, int joints, float *q, float *dq) {
    for (int n = 0; n < joints; n++) {
        float x = (float)((k + 9 * n) % 64) / 64.0f;
        q[n] = x - 0.5f;
        dq[n] = 0.5f - x;
    }
}

static inline uint32_t bits_of(const float *x) {
    uint32_t bits;
    memcpy(&bits, x, sizeof bits);
    return bits;
}

#endif
