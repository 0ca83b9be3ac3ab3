/*
 * A controller of a mission m is walked at random, the same way wherever it is compiled: a line for each event.
 * The line is a hash of all that the controller says: status and actions, what runs, what is possible, validity.
 *
 * The controller itself is asked which events are possible, so one answer that differs changes all that follows.
 * STEP: milliseconds that most times are multiples of, where there are timers. CYCLES: on an AVR, what events cost.
 */
#include "m.h"

#ifndef EVENTS
#define EVENTS 5000U
#endif

/* --- the board: a character to whoever listens, and the end of the program ---------------------------- */

#if defined(__AVR__)
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>

static void put(char character)
{
    while ((UCSR0A & (1U << UDRE0)) == 0U) { }
    UDR0 = (uint8_t)character;
}

static void leave(void)
{
    while ((UCSR0A & (1U << TXC0)) == 0U) { }
    cli();
    sleep_enable();
    sleep_cpu(); /* the simulator ends where nothing can wake it */
}

#elif defined(__ARM_ARCH) && !defined(__linux__)
int main(void);

static void semihosting(uint32_t operation, uint32_t argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register uint32_t r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
}

static void put(char character)
{
    semihosting(3U, (uint32_t)&character);
}

static void leave(void)
{
    semihosting(0x18U, 0x20026U);
}

static void reset(void)
{
    (void)main();
    leave();
}

__attribute__((section(".vectors"), used)) static void (*const vectors[2])(void) = {
    (void (*)(void))STACK, reset
};

#elif defined(__riscv) && !defined(__linux__)
int main(void);

static void call(long number, long first, long second, long third)
{
    register long a0 __asm__("a0") = first;
    register long a1 __asm__("a1") = second;
    register long a2 __asm__("a2") = third;
    register long a7 __asm__("a7") = number;
    __asm__ volatile("ecall" : "+r"(a0) : "r"(a1), "r"(a2), "r"(a7) : "memory");
}

static void put(char character)
{
    call(64, 1, (long)&character, 1);
}

static void leave(void)
{
    call(93, 0, 0, 0);
}

/* No library is linked; compilers ask for this one where structures are copied. */
void *memcpy(void *to, const void *from, size_t count);
void *memcpy(void *to, const void *from, size_t count)
{
    volatile uint8_t *const written = (volatile uint8_t *)to;
    const uint8_t *const read = (const uint8_t *)from;
    size_t i;
    for (i = 0U; i < count; i++) {
        written[i] = read[i];
    }
    return to;
}

void _start(void);
void _start(void)
{
    __asm__ volatile(".option push\n.option norelax\nla gp, __global_pointer$\n.option pop");
    (void)main();
    leave();
}

#else
#include <stdio.h>

static void put(char character)
{
    (void)putchar(character);
}

static void leave(void)
{
}
#endif

/* --- what events cost --------------------------------------------------------------------------------- */

#ifdef CYCLES
static uint32_t cycles_in_all;
static uint32_t cycles_at_most;
static uint32_t cycles_of_none;

/* Timer 1 counts cycles, and once that it came round. */
static void begin(void)
{
    TCCR1B = 1U;
    TCNT1 = 0U;
    TIFR1 = (uint8_t)(1U << TOV1);
}

static uint32_t cycles(void)
{
    const uint16_t counted = TCNT1;
    return (uint32_t)counted + (((TIFR1 & (1U << TOV1)) != 0U) ? (uint32_t)65536 : (uint32_t)0);
}
#endif

static m_status handle(m_controller *self, m_event event, m_action *actions, size_t *count)
{
    m_status status;
#ifdef CYCLES
    uint32_t found;
    begin();
    status = m_handle(self, event, actions, count);
    found = cycles() - cycles_of_none;
    cycles_in_all += found;
    cycles_at_most = (found > cycles_at_most) ? found : cycles_at_most;
#else
    status = m_handle(self, event, actions, count);
#endif
    return status;
}

/* --- the walk ------------------------------------------------------------------------------------------ */

static m_controller controller;
static m_action actions[M_MAX_ACTIONS];
static uint32_t hash;
static uint32_t seed = 1U;
static uint16_t handled;

/* A number below some other one. */
static uint16_t drawn(uint16_t below)
{
    seed = (seed * (uint32_t)1664525) + (uint32_t)1013904223;
    return (uint16_t)((seed >> 16U) % below);
}

static void add(uint32_t number)
{
    uint8_t i;
    for (i = 0U; i < 4U; i++) {
        hash = (hash ^ ((number >> (8U * i)) & 0xFFU)) * (uint32_t)16777619;
    }
}

static void print(uint32_t number)
{
    uint8_t i;
    for (i = 0U; i < 8U; i++) {
        const uint8_t digit = (uint8_t)((number >> (28U - (4U * i))) & 0xFU);
        put((char)(digit + ((digit < 10U) ? (uint8_t)'0' : (uint8_t)('a' - 10))));
    }
    put('\n');
}

/* A number of the controller; none is the same however wide numbers are. */
static void add_number(m_number number)
{
    add((number == M_NONE) ? (uint32_t)0xFFFFFFFFU : (uint32_t)number);
}

/* Before the start, inside the mission, or how it ended: sections have other numbers in other forms. */
static uint8_t phase(void)
{
    uint8_t found = 4U;
    if (controller.section == M_NONE) {
        found = 0U;
    } else if (controller.section == M_SUCCESS) {
        found = 1U;
    } else if (controller.section == M_FAILURE) {
        found = 2U;
    } else if (controller.section < M_COUNT_SECTION) {
        found = 3U;
    } else {
        /* It was aborted. */
    }
    return found;
}

static void take(m_event event)
{
    size_t count = 0U;
    size_t i;
    hash = (uint32_t)2166136261U;
    add((uint32_t)event);
    add((uint32_t)handle(&controller, event, actions, &count));
    add((uint32_t)count);
    for (i = 0U; i < count; i++) {
        add((uint32_t)actions[i].verb);
        add_number(actions[i].subject);
        add_number(actions[i].alternative);
        add_number(actions[i].objective);
    }
    add((uint32_t)phase());
    add((uint32_t)m_valid(&controller));
    for (i = 0U; i < M_COUNT_ACTIVITY; i++) {
        add_number(m_running(&controller, (m_number)i));
    }
    for (i = 0U; i <= M_COUNT_EVENT; i++) {
        if (m_possible(&controller, (m_event)i) != 0) {
            add((uint32_t)i);
        }
    }
    print(hash);
    handled++;
}

/* The first event that is possible from some number on, in a circle. */
static m_event possible_from(m_event first)
{
    m_event event = first;
    do {
        event = (m_event)((event + 1U) % M_COUNT_EVENT);
    } while ((event != first) && (m_possible(&controller, event) == 0));
    return event;
}

#ifdef STEP
static void let(uint32_t milliseconds)
{
    m_event event = m_tick(&controller, milliseconds);
    while (event != M_NO_EVENT) {
        take(event);
        event = m_tick(&controller, 0U);
    }
}
#endif

int main(void)
{
    uint8_t after_the_end = 6U;
#ifdef __AVR__
    UCSR0A = (uint8_t)(1U << U2X0);
    UCSR0B = (uint8_t)(1U << TXEN0);
#endif
#ifdef CYCLES
    begin();
    cycles_of_none = cycles();
#endif
    while (handled < EVENTS) {
        const uint16_t chosen = drawn(8U);
        if (after_the_end > 5U) {
            m_init(&controller);
            after_the_end = 0U;
#ifdef STEP
        } else if (chosen > 4U) {
            let((uint32_t)(STEP * (1UL + (uint32_t)drawn(4U))));
#endif
        } else if (chosen == 0U) {
            take((m_event)drawn((uint16_t)(M_COUNT_EVENT + 2U)));
        } else {
            take(possible_from((m_event)drawn((uint16_t)M_COUNT_EVENT)));
        }
        if ((phase() != 0U) && (phase() != 3U)) {
            after_the_end++;
        }
    }
#ifdef CYCLES
    print(cycles_in_all);
    print(cycles_at_most);
#endif
    leave();
    return 0;
}
