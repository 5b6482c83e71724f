/* SPDX-License-Identifier: MIT */
/* Arm's MPS2 boards without an operating system: vectors, reset, and semihosting for output. */
#include "../port.h"

#include <stdint.h>

extern uint32_t stack_top[], stack_end[], data_begin[], data_end[], bss_begin[], bss_end[];
extern const uint32_t data_image[];
int main(void);
void reset(void);

#define PATTERN 0xa5c35a3cu

enum { SYS_WRITE0 = 0x04, SYS_EXIT = 0x18 };
enum { STOPPED_WELL = 0x20026, STOPPED_BY_ERROR = 0x20023 };

static void semihost(uint32_t operation, uintptr_t argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register uintptr_t r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

void port_write(const char *text) { semihost(SYS_WRITE0, (uintptr_t)text); }

__attribute__((noinline)) void port_stack_paint(void)
{
    uint32_t *here;
    __asm__ volatile("mov %0, sp" : "=r"(here));
    for (uint32_t *p = stack_end; p < here; p++)
        *(volatile uint32_t *)p = PATTERN;
}

static uint32_t *painted_from(void)
{
    uint32_t *p = stack_end;
    while (p < stack_top && *p == PATTERN)
        p++;
    return p;
}

__attribute__((noinline)) size_t port_stack_used(void)
{
    uint32_t *here;
    __asm__ volatile("mov %0, sp" : "=r"(here));
    const uint32_t *deepest = painted_from();
    return deepest < here ? (size_t)((const char *)here - (const char *)deepest) : 0;
}

static void fault(void)
{
    port_write("# fault\n");
    semihost(SYS_EXIT, STOPPED_BY_ERROR);
    for (;;)
        ;
}

void reset(void)
{
    volatile uint32_t *const cpacr = (volatile uint32_t *)0xe000ed88u;
    *cpacr |= 0xfu << 20; /* switch the floating-point unit on */
    __asm__ volatile("dsb\n\tisb");
    const uint32_t *from = data_image;
    for (uint32_t *p = data_begin; p < data_end; p++)
        *(volatile uint32_t *)p = *from++;
    for (uint32_t *p = bss_begin; p < bss_end; p++)
        *(volatile uint32_t *)p = 0;
    semihost(SYS_EXIT, main() == 0 ? STOPPED_WELL : STOPPED_BY_ERROR);
    fault();
}

/* Stack pointer, reset, and the faults up to SysTick. */
__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void))(uintptr_t)stack_top,
    reset,
    fault,
    fault,
    fault,
    fault,
    fault,
    fault,
    fault,
    fault,
    fault,
    fault,
    fault,
    fault,
    fault,
    fault};
