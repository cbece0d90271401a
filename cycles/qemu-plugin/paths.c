/* QEMU TCG plugin: the exact instruction path of every call of listed functions.
 *
 * Arguments: entries=FILE (one hexadecimal function address a line), out=FILE, and where wanted skip=FILE, in the
 * format of entries: a call of such a function is passed over with all that it calls, as if it did nothing.
 * A call is recorded from its entry to its return, with everything it calls, as runs of consecutive
 * instructions. Equal paths are counted, not repeated. At exit the output file gets, as 32-bit words in host byte
 * order, for each path: entry address, number of calls, number of runs, then first and last address of each run;
 * and finally 0, number of calls that had not returned.
 *
 * A call has ended when a return instruction leads to no return address that was left behind on the way. So
 * interrupt handlers work as well, and so does libgcc's assembly, which calls parts of itself that return past
 * their caller. What is listed must not be interrupted while it runs.
 *
 * Debian ships no qemu-plugin.h, so the part of API version 1 that is used here is declared by hand. */

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
typedef struct qemu_info_t qemu_info_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
enum qemu_plugin_cb_flags { QEMU_PLUGIN_CB_NO_REGS };

size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *tb);
struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *tb, size_t index);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *insn);
const void *qemu_plugin_insn_data(const struct qemu_plugin_insn *insn);
size_t qemu_plugin_insn_size(const struct qemu_plugin_insn *insn);
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id,
                                           void (*translated)(qemu_plugin_id_t, struct qemu_plugin_tb *));
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn *insn, void (*executed)(unsigned, void *),
                                            enum qemu_plugin_cb_flags flags, void *userdata);
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t id, void (*exiting)(qemu_plugin_id_t, void *), void *userdata);

#define EXPORT __attribute__((visibility("default")))
EXPORT int qemu_plugin_version = 1;

enum kind { PLAIN, CALL, RETURN };

struct instruction {
    uint32_t address, next;
    enum kind kind;
    bool is_entry, is_skipped;
};

struct run {
    uint32_t first, last;
};

struct path {
    struct path *next;
    uint32_t entry, calls, run_count;
    struct run runs[];
};

struct list {
    uint32_t *addresses;
    size_t count;
};

static struct list entries, skipped;
static const char *output_name;

/* A power of two well above the number of distinct paths that a run meets. */
#define BUCKETS (1u << 17)
static struct path *paths[BUCKETS];

/* The call that is being recorded. */
static bool recording;
static uint32_t entry;
static uint32_t return_to[64];
static unsigned depth;
static struct run *runs;
static size_t run_count, run_capacity;
static const struct instruction *previous;
/* Where a call that is passed over returns to; 0 outside one. */
static uint32_t resume;

static void *checked(void *memory)
{
    if (!memory) {
        fputs("paths: out of memory\n", stderr);
        abort();
    }
    return memory;
}

static void finish(void)
{
    size_t bytes = run_count * sizeof *runs;
    uint64_t hash = 14695981039346656037u; /* FNV-1a over words */
    const uint32_t *words = (const uint32_t *)runs;
    for (size_t i = 0; i < bytes / sizeof *words; i++)
        hash = (hash ^ words[i]) * 1099511628211u;
    struct path **slot = &paths[(hash ^ hash >> 32) % BUCKETS];
    for (; *slot; slot = &(*slot)->next) {
        struct path *path = *slot;
        if (path->entry == entry && path->run_count == run_count && !memcmp(path->runs, runs, bytes)) {
            path->calls++;
            return;
        }
    }
    struct path *path = checked(malloc(sizeof *path + bytes));
    *path = (struct path){ .entry = entry, .calls = 1, .run_count = (uint32_t)run_count };
    memcpy(path->runs, runs, bytes);
    *slot = path;
}

/* Whether a return to this address leaves the recorded function; unwinds to it if not. */
static bool leaves(uint32_t address)
{
    for (unsigned level = depth; level > 0; level--)
        if (return_to[level - 1] == address) {
            depth = level - 1;
            return false;
        }
    return true;
}

static void executed(unsigned cpu, void *userdata)
{
    (void)cpu;
    const struct instruction *now = userdata;
    if (resume) {
        if (now->address != resume)
            return;
        resume = 0;
    } else if (recording && now->is_skipped && previous->kind == CALL && previous->next != now->address) {
        resume = previous->next;
        return;
    }
    bool sequential = recording && now->address == previous->next;
    if (recording && !sequential) { /* a call or return whose condition failed falls through */
        if (previous->kind == CALL) {
            if (depth == sizeof return_to / sizeof *return_to) {
                fprintf(stderr, "paths: calls nest too deeply at %#x\n", (unsigned)previous->address);
                abort();
            }
            return_to[depth++] = previous->next;
        } else if (previous->kind == RETURN && leaves(now->address)) {
            finish();
            recording = false;
        }
    }
    if (!recording) {
        if (!now->is_entry)
            return;
        recording = true;
        entry = now->address;
        depth = 0;
        run_count = 0;
    }
    if (sequential) {
        runs[run_count - 1].last = now->address;
    } else {
        if (run_count == run_capacity) {
            run_capacity = run_capacity ? 2 * run_capacity : 1024;
            runs = checked(realloc(runs, run_capacity * sizeof *runs));
        }
        runs[run_count++] = (struct run){ now->address, now->address };
    }
    previous = now;
}

static bool contains(const struct list *list, uint32_t address)
{
    for (size_t i = 0; i < list->count; i++)
        if (list->addresses[i] == address)
            return true;
    return false;
}

static enum kind kind_of(const uint16_t *halfwords, size_t size)
{
    uint16_t first = halfwords[0];
    if (size == 2) {
        if ((first & 0xff87) == 0x4780) /* BLX register */
            return CALL;
        bool bx_lr = first == 0x4770, mov_pc_lr = first == 0x46f7, pop_pc = (first & 0xff00) == 0xbd00;
        return bx_lr || mov_pc_lr || pop_pc ? RETURN : PLAIN;
    }
    uint16_t second = halfwords[1];
    if ((first & 0xf800) == 0xf000 && (second & 0xd000) == 0xd000) /* BL */
        return CALL;
    bool pop_pc = first == 0xe8bd && (second & 0x8000);
    bool ldr_pc = first == 0xf85d && (second & 0xff00) == 0xfb00; /* LDR pc, [sp], #4 or #8 */
    return pop_pc || ldr_pc ? RETURN : PLAIN;
}

static void translated(qemu_plugin_id_t id, struct qemu_plugin_tb *tb)
{
    (void)id;
    for (size_t i = 0; i < qemu_plugin_tb_n_insns(tb); i++) {
        struct qemu_plugin_insn *insn = qemu_plugin_tb_get_insn(tb, i);
        size_t size = qemu_plugin_insn_size(insn);
        uint16_t halfwords[2] = { 0 };
        memcpy(halfwords, qemu_plugin_insn_data(insn), size <= sizeof halfwords ? size : sizeof halfwords);
        struct instruction *record = checked(malloc(sizeof *record)); /* lives as long as its translation */
        record->address = (uint32_t)qemu_plugin_insn_vaddr(insn);
        record->next = record->address + (uint32_t)size;
        record->kind = kind_of(halfwords, size);
        record->is_entry = contains(&entries, record->address);
        record->is_skipped = contains(&skipped, record->address);
        qemu_plugin_register_vcpu_insn_exec_cb(insn, executed, QEMU_PLUGIN_CB_NO_REGS, record);
    }
}

static void exiting(qemu_plugin_id_t id, void *userdata)
{
    (void)id, (void)userdata;
    FILE *output = fopen(output_name, "wb");
    if (!output) {
        perror(output_name);
        return;
    }
    for (size_t i = 0; i < BUCKETS; i++)
        for (const struct path *path = paths[i]; path; path = path->next) {
            fwrite(&path->entry, sizeof(uint32_t), 3, output);
            fwrite(path->runs, sizeof *path->runs, path->run_count, output);
        }
    uint32_t end[2] = { 0, recording };
    fwrite(end, sizeof end, 1, output);
    if (fclose(output))
        perror(output_name);
}

static bool read_list(struct list *list, const char *name)
{
    FILE *file = fopen(name, "r");
    if (!file) {
        perror(name);
        return false;
    }
    unsigned address;
    while (fscanf(file, "%x", &address) == 1) {
        list->addresses = checked(realloc(list->addresses, (list->count + 1) * sizeof *list->addresses));
        list->addresses[list->count++] = address;
    }
    fclose(file);
    return list->count > 0;
}

EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t *info, int argc, char **argv)
{
    (void)info;
    bool has_entries = false;
    for (int i = 0; i < argc; i++) {
        if (!strncmp(argv[i], "entries=", 8))
            has_entries = read_list(&entries, argv[i] + 8);
        else if (!strncmp(argv[i], "skip=", 5))
            read_list(&skipped, argv[i] + 5);
        else if (!strncmp(argv[i], "out=", 4))
            output_name = strdup(argv[i] + 4);
    }
    if (!has_entries || !output_name) {
        fputs("paths: give entries=FILE, with at least one address in it, and out=FILE\n", stderr);
        return -1;
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, exiting, NULL);
    return 0;
}
