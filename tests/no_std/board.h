/* ARM's MPS2 board in an emulator, without an operating system: what it prints, the stack and the
 * instructions that a function takes. The program is `measure`.
 *
 * Stack is painted before a call and looked at afterwards. Instructions are counted by SysTick,
 * in an emulator whose clock goes on by 32 ns an instruction. */
#ifndef BOARD_H
#define BOARD_H

#include <stddef.h>
#include <stdint.h>

#define PAINT 0xa5a5a5a5u
#define TICK_NS 40
#define INSTRUCTION_NS 32

extern uint32_t stack_limit[], stack_top[], bss_start[], bss_end[];

static volatile uint32_t *const access_control = (uint32_t *)0xe000ed88;
static volatile uint32_t *const tick = (uint32_t *)0xe000e010;

/* Semihosting: the emulator does what is asked for. */
static int ask(int operation, const void *argument) {
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void print(const char *text) { ask(0x04, text); }

/* At least `width` digits. */
static void print_number(const char *name, uint64_t value, unsigned base, int width) {
    char digits[24];
    char *place = digits + sizeof digits - 1;
    *place = 0;
    for (; value != 0 || width > 0; width--) {
        *--place = "0123456789abcdef"[value % base];
        value /= base;
    }
    print(name);
    print(" ");
    print(place);
    print("\n");
}

static void leave(uint32_t code) {
    const uint32_t reason[2] = {0x20026, code};
    ask(0x20, reason);
    for (;;) {
    }
}

/* Bytes of stack that `run` takes. */
static __attribute__((noinline)) uint32_t stack_of(void (*run)(void)) {
    uint32_t *here = __builtin_frame_address(0);
    here -= 64;
    for (volatile uint32_t *word = stack_limit; word < here; word++) {
        *word = PAINT;
    }
    run();
    volatile uint32_t *lowest = stack_limit;
    while (*lowest == PAINT) {
        lowest++;
    }
    return ((uint32_t *)__builtin_frame_address(0) - (uint32_t *)lowest) * sizeof *lowest;
}

/* Instructions that `run` takes. */
static __attribute__((noinline)) uint32_t instructions_of(void (*run)(void)) {
    uint32_t before = tick[2];
    run();
    return ((before - tick[2]) & 0xffffff) * TICK_NS / INSTRUCTION_NS;
}

static void start_counting(void) {
    tick[1] = 0xffffff;
    tick[2] = 0;
    tick[0] = 5;
}

static void measure(void);

static void reset(void) {
    *access_control |= 0xf << 20; /* The floating-point unit. */
    __asm__ volatile("dsb; isb");
    for (uint32_t *word = bss_start; word < bss_end; word++) {
        *word = 0;
    }
    measure();
}

static void fault(void) { leave(3); }

__attribute__((section(".vectors"), used)) const void *const vectors[16] = {
    stack_top, reset, fault, fault, fault, fault, fault,
};

#endif
