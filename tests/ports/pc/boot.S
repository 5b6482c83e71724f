/* SPDX-License-Identifier: MIT */
/* A PC without an operating system, as far as a statically linked Linux program needs one: from the
 * reset vector to long mode with AVX-512 on, then to ENTRY of the program, which lies in memory
 * already but for ZEROS_SIZE bytes at ZEROS. Five system calls work, all others fail. Standard output goes to the first serial port,
 * and after it a line with the exit status. An exception stops the machine: nothing catches it. */
#define CR0   0x80000033 /* PE MP ET NE PG */
#define CR4   0x00040620 /* PAE OSFXSR OSXMMEXCPT OSXSAVE */
#define EFER  0x101      /* SCE LME */
#define XCR0  0xe7       /* x87, SSE, AVX and the three parts of AVX-512 */
#define CODE  8          /* selectors */
#define DATA  16

#define SYSTEM_STACK 0x8000 /* downwards; the word at it holds where the free heap begins */
#define STACK        0xa0000
#define HEAP         0x2000000

#define SERIAL   0x3f8
#define POWER    0x8900 /* of Bochs: the word "Shutdown" switches it off */

    .text
    .globl start
base:
    .code16
start:
    cli
    lgdtl %cs:gdt_pointer - base
    mov $CR4, %eax
    mov %eax, %cr4
    mov $pages, %eax
    mov %eax, %cr3
    mov $0xc0000080, %ecx
    xor %edx, %edx
    mov $EFER, %eax
    wrmsr
    mov $CR0, %eax
    mov %eax, %cr0
    ljmpl $CODE, $long_mode

    .code64
long_mode:
    mov $DATA, %eax
    mov %eax, %ds
    mov %eax, %es
    mov %eax, %ss
    xor %ecx, %ecx
    xor %edx, %edx
    mov $XCR0, %eax
    xsetbv
    fninit
    mov $0xc0000081, %ecx /* STAR: system calls stay in this ring */
    mov $CODE, %edx
    xor %eax, %eax
    wrmsr
    inc %ecx /* LSTAR */
    xor %edx, %edx
    mov $system_call, %eax
    wrmsr
    mov $SERIAL + 3, %edx
    mov $3, %al /* 8 bits, no parity, 1 stop bit */
    out %al, %dx
    mov $ZEROS, %edi
    mov $ZEROS_SIZE, %ecx
    xor %eax, %eax
    rep stosb
    movq $HEAP, SYSTEM_STACK
    mov $STACK, %esp
    .rept 8 /* no arguments, no environment, no auxiliary vector */
    pushq $0
    .endr
    mov $ENTRY, %eax
    jmp *%rax

    /* rax: number, then result; rdi, rsi, rdx: arguments; rcx: where to return; r11 is free */
system_call:
    mov %rsp, %r11
    mov $SYSTEM_STACK, %esp
    push %r11
    push %rcx
    push %rdx
    push %rsi
    push %rdi
    cmp $1, %eax
    je write
    cmp $9, %eax
    je mmap
    cmp $20, %eax
    je writev
    cmp $158, %eax
    je arch_prctl
    cmp $231, %eax
    je exit_group
    mov $-38, %rax /* ENOSYS */
return:
    pop %rdi
    pop %rsi
    pop %rdx
    pop %rcx
    pop %rsp
    jmp *%rcx

write:
    mov %rdx, %rax
    mov %rdx, %rcx
    call put
    jmp return

writev:
    xor %eax, %eax
    mov %rdx, %rdi
    mov %rsi, %r11
1:  dec %rdi
    js return
    mov (%r11), %rsi
    mov 8(%r11), %rcx
    add %rcx, %rax
    add $16, %r11
    call put
    jmp 1b

    /* rcx bytes from rsi; destroys rcx, rdx, rsi */
put:
    push %rax
1:  dec %rcx
    js 3f
    mov $SERIAL + 5, %edx
2:  in %dx, %al
    test $0x20, %al /* room for one more */
    jz 2b
    mov $SERIAL, %edx
    outsb
    jmp 1b
3:  pop %rax
    ret

arch_prctl: /* ARCH_SET_FS: a C library asks for nothing else */
    mov $0xc0000100, %ecx
    mov %rsi, %rdx
    shr $32, %rdx
    mov %esi, %eax
    wrmsr
    xor %eax, %eax
    jmp return

mmap: /* fresh memory, never given back */
    add $4095, %rsi
    and $-4096, %rsi
    mov SYSTEM_STACK, %rax
    add %rsi, SYSTEM_STACK
    jmp return

exit_group:
    movabs $0x0a302074697865, %rax /* "exit 0\n" */
    shl $40, %rdi
    add %rdi, %rax
    push %rax
    mov %rsp, %rsi
    mov $7, %ecx
    call put
    mov $SERIAL + 5, %edx
1:  in %dx, %al
    test $0x40, %al /* all is sent */
    jz 1b
    mov $shutdown, %esi
    mov $8, %ecx
    mov $POWER, %edx
    rep outsb
    hlt

shutdown:
    .ascii "Shutdown"

    .balign 8
gdt:
    .quad 0
    .quad 0x00af9b000000ffff /* code, 64 bits */
    .quad 0x00cf93000000ffff /* data */
gdt_pointer:
    .word gdt_pointer - gdt - 1
    .long gdt

    /* Every address is its own, in pages of 1 GiB, marked as used: this is read-only memory. */
    .org 0x1000
pages:
    .quad pages_of_4_gib + 0x23
    .org 0x2000
pages_of_4_gib:
    .quad 0x000000e3, 0x400000e3, 0x800000e3, 0xc00000e3

    .org 0xfff0 /* where the processor begins */
    .code16
    jmp start
    .org 0x10000
