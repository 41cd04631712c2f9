/* The start of a Cortex-M0 to M4F: vectors, floating-point unit, main; an exception ends the program with an error. */
    .syntax unified
    .section .vectors, "a"
    .word 0x20400000
    .word reset
    .rept 14
    .word fault
    .endr

    .section .text.reset, "ax"
    .thumb_func
    .global reset
    .type reset, %function
reset:
    /* CPACR: full access to coprocessors 10 and 11; without a unit the write has no effect. */
    ldr r0, =0xE000ED88
    ldr r1, [r0]
    ldr r2, =0x00F00000
    orrs r1, r2
    str r1, [r0]
    dsb
    isb
    bl main
    .thumb_func
    .type fault, %function
fault:
    /* SYS_EXIT, ADP_Stopped_RunTimeErrorUnknown. */
    movs r0, #0x18
    ldr r1, =0x20023
    bkpt 0xAB
    b fault
    .pool
