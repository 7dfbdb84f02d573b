/* The samples that the controller is stepped with, and a hash of its torques. */
#ifndef SAMPLES_H
#define SAMPLES_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define SAMPLES 1000
#define HASH_START 0xcbf29ce484222325u

/* Sums and products only: the same numbers in every language. */
static inline void sample(int k, double *q, double *dq) {
    double x = (double)(k % 64) / 64.0;
    q[0] = x - 0.5;
    q[1] = 0.25 - x * x;
    dq[0] = 1.0 - x;
    dq[1] = x;
}

/* FNV-1a of the bits of both torques, from `hash` on. */
static inline uint64_t hashed(uint64_t hash, const double *tau) {
    for (int n = 0; n < 2; n++) {
        uint64_t bits;
        memcpy(&bits, &tau[n], sizeof bits);
        for (int byte = 0; byte < 8; byte++) {
            hash = (hash ^ ((bits >> (8 * byte)) & 0xff)) * 0x100000001b3u;
        }
    }
    return hash;
}

/* In the crate, see src/lib.rs. 0 if all went well. */
int steadyarm_start(void);
int steadyarm_step(const double *q, const double *dq, double *tau);
/* Bytes of controller, basis, state, and of the memory that is lent to the state. */
void steadyarm_sizes(size_t *sizes);

#endif
