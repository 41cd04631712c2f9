/* The start of a hart: stack, floating-point unit, main; an exception ends the program with an error. */
    .section .vectors, "ax"
    .global reset
reset:
    li sp, 0x80400000
    /* mstatus.FS: dirty. */
    li t0, 0x6000
    csrs mstatus, t0
    la t0, fault
    csrw mtvec, t0
    call main
    .option norvc
    .balign 16
fault:
    /* SYS_EXIT, ADP_Stopped_RunTimeErrorUnknown. */
    li a0, 0x18
    li a1, 0x20023
    .balign 16
    slli x0, x0, 0x1f
    ebreak
    srai x0, x0, 7
    j fault
