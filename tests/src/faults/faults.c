/* Faults of the system, on demand, for a program that is started with this library in LD_PRELOAD.
 *
 *   FAULT_THREADS=n  threads after the n-th are refused with EAGAIN
 *   FAULT_UNDER=dir  operations on files below this folder count: everything that creates, writes, flushes, renames or removes
 *   FAULT_LOG=file   each counted operation adds a line to this file: its name and its path
 *   FAULT_AT=k       what is done at the k-th counted operation, from 1:
 *   FAULT_HOW=kill   the process ends by SIGKILL before it
 *   FAULT_HOW=EIO    it fails, once
 *   FAULT_HOW=ENOSPC it fails, and so does every later one that creates or writes
 *
 * Calls are caught by seccomp, so those that go around libc count too; the handler of SIGSYS then makes the call itself, from an instruction that
 * the filter lets through.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <pthread.h>
#include <signal.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

/* Makes a system call; `through_end` is the address behind its instruction, by which the filter knows it. */
long through(long number, long a, long b, long c, long d, long e, long f);
extern const char through_end[];
__asm__(".text\n.globl through\n.type through, @function\nthrough:\n"
        "mov %rdi, %rax\nmov %rsi, %rdi\nmov %rdx, %rsi\nmov %rcx, %rdx\nmov %r8, %r10\nmov %r9, %r8\nmov 8(%rsp), %r9\n"
        "syscall\n.globl through_end\nthrough_end:\nret\n");

enum kind { WRITES, FLUSHES, RENAMES, REMOVES };

/* Calls that count; `path` is the number of the argument that tells the file, a descriptor where `is_fd`. */
static const struct call {
    const char *name;
    int number, path, is_fd;
    enum kind kind;
} CALLS[] = {
    {"write", SYS_write, 0, 1, WRITES},         {"writev", SYS_writev, 0, 1, WRITES},
    {"pwrite", SYS_pwrite64, 0, 1, WRITES},     {"ftruncate", SYS_ftruncate, 0, 1, WRITES},
    {"open", SYS_open, 0, 0, WRITES},           {"openat", SYS_openat, 1, 0, WRITES},
    {"mkdir", SYS_mkdir, 0, 0, WRITES},         {"mkdirat", SYS_mkdirat, 1, 0, WRITES},
    {"copy", SYS_copy_file_range, 2, 1, WRITES}, {"sendfile", SYS_sendfile, 0, 1, WRITES},
    {"link", SYS_link, 1, 0, WRITES},           {"linkat", SYS_linkat, 3, 0, WRITES},
    {"fsync", SYS_fsync, 0, 1, FLUSHES},        {"fdatasync", SYS_fdatasync, 0, 1, FLUSHES},
    {"rename", SYS_rename, 1, 0, RENAMES},      {"renameat", SYS_renameat, 3, 0, RENAMES},
    {"renameat2", SYS_renameat2, 3, 0, RENAMES}, {"unlink", SYS_unlink, 0, 0, REMOVES},
    {"unlinkat", SYS_unlinkat, 1, 0, REMOVES},  {"rmdir", SYS_rmdir, 0, 0, REMOVES},
};
enum { COUNT = sizeof CALLS / sizeof *CALLS };

static const char *under, *how;
static int log_file = -1;
static long fails_at, counted, is_full;

static const char *number_text(long number, char *end) {
    *--end = 0;
    do *--end = (char)('0' + number % 10);
    while (number /= 10);
    return end;
}

/* The file of a call, absolute or as it was given; empty where it has none. */
static void file_of(const struct call *call, const long *argument, char *path, size_t size) {
    if (!call->is_fd) {
        strncpy(path, (const char *)argument[call->path], size - 1);
        path[size - 1] = 0;
        return;
    }
    char link[64] = "/proc/self/fd/", digits[32];
    strcat(link, number_text(argument[call->path], digits + sizeof digits));
    long length = through(SYS_readlinkat, AT_FDCWD, (long)link, (long)path, (long)size - 1, 0, 0);
    path[length > 0 ? length : 0] = 0;
}

static int counts(const struct call *call, const long *argument, const char *path) {
    int flags = call->number == SYS_open ? (int)argument[1] : call->number == SYS_openat ? (int)argument[2] : -1;
    if (flags != -1 && !(flags & (O_CREAT | O_TRUNC)) && (flags & O_TMPFILE) != O_TMPFILE) return 0;
    return path[0] != '/' ? !call->is_fd : strncmp(path, under, strlen(under)) == 0;
}

static void tell(const char *name, const char *path) {
    char line[4200];
    size_t length = (size_t)snprintf(line, sizeof line, "%s %s\n", name, path);
    if (log_file >= 0) through(SYS_write, log_file, (long)line, (long)length, 0, 0, 0);
}

static long result_of(const struct call *call, const long *argument) {
    char path[4096];
    file_of(call, argument, path, sizeof path);
    if (counts(call, argument, path)) {
        long at = __atomic_add_fetch(&counted, 1, __ATOMIC_SEQ_CST);
        tell(call->name, path);
        if (at == fails_at && strcmp(how, "kill") == 0) through(SYS_kill, through(SYS_getpid, 0, 0, 0, 0, 0, 0), SIGKILL, 0, 0, 0, 0);
        if (at == fails_at && strcmp(how, "EIO") == 0) return -EIO;
        if (at == fails_at && strcmp(how, "ENOSPC") == 0) __atomic_store_n(&is_full, 1, __ATOMIC_SEQ_CST);
        /* A rename needs room for a name; what removes needs none. */
        int needs_room = call->kind == WRITES || call->kind == FLUSHES || at == fails_at;
        if (__atomic_load_n(&is_full, __ATOMIC_SEQ_CST) && needs_room && call->kind != REMOVES) return -ENOSPC;
    }
    return through(call->number, argument[0], argument[1], argument[2], argument[3], argument[4], argument[5]);
}

static void on_call(int signal, siginfo_t *info, void *context) {
    (void)signal;
    greg_t *registers = ((ucontext_t *)context)->uc_mcontext.gregs;
    long argument[6] = {registers[REG_RDI], registers[REG_RSI], registers[REG_RDX],
                        registers[REG_R10], registers[REG_R8],  registers[REG_R9]};
    for (int i = 0; i < COUNT; ++i)
        if (CALLS[i].number == info->si_syscall) registers[REG_RAX] = result_of(&CALLS[i], argument);
}

static int install(void) {
    struct sigaction action = {.sa_sigaction = on_call, .sa_flags = SA_SIGINFO | SA_NODEFER | SA_RESTART};
    if (sigaction(SIGSYS, &action, NULL)) return -1;
    uint64_t end = (uint64_t)(uintptr_t)through_end;
    struct sock_filter filter[COUNT + 8] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, instruction_pointer)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)end, 0, 3),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, instruction_pointer) + 4),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)(end >> 32), 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
    };
    for (int i = 0; i < COUNT; ++i)
        filter[6 + i] = (struct sock_filter)BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, (uint32_t)CALLS[i].number, (uint8_t)(COUNT - i), 0);
    filter[6 + COUNT] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
    filter[7 + COUNT] = (struct sock_filter)BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP);
    struct sock_fprog program = {.len = COUNT + 8, .filter = filter};
    return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) || prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program);
}

__attribute__((constructor)) static void begin(void) {
    const char *at = getenv("FAULT_AT"), *file = getenv("FAULT_LOG");
    if (!(under = getenv("FAULT_UNDER"))) return;
    how = getenv("FAULT_HOW") ? getenv("FAULT_HOW") : "";
    fails_at = at ? atol(at) : 0;
    if (file) log_file = open(file, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (install()) {
        perror("faults: the system does not let calls be caught");
        _exit(99);
    }
}

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *), void *argument) {
    static long created;
    const char *most = getenv("FAULT_THREADS");
    if (most && __atomic_add_fetch(&created, 1, __ATOMIC_SEQ_CST) > atol(most)) return EAGAIN;
    int (*create)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    *(void **)&create = dlsym(RTLD_NEXT, "pthread_create");
    return create(thread, attributes, start, argument);
}
